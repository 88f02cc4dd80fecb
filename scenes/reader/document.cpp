#include "scenes/reader/document.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <numeric>

#include "scenes/regular_file.h"

namespace taut {

namespace {

constexpr std::size_t kMaxBytes = 16 << 20;
// The parser makes one nested table of each dotted part, and frees them recursively.
constexpr int kMaxDots = 64;

[[noreturn]] void fail_place(const std::filesystem::path& file, SourcePosition place,
                             const std::string& message) {
  throw BadScene(fmt::format("{}:{}:{}: {}", file.string(), place.line, place.column, message));
}

void check_dots(const std::filesystem::path& file, std::string_view text) {
  int line = 1, dots = 0;
  for (const char c : text) {
    if (c == '.') {
      if (++dots > kMaxDots) {
        fail_place(file, {line, 1}, fmt::format("more than {} dots in a row of words", kMaxDots));
      }
    } else if (c == '\n' || c == ',' || c == '=') {
      dots = 0;
      line += c == '\n';
    }
  }
}

SourcePosition place_of(const toml::source_region& region) {
  return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

Value converted(const toml::node& node, std::string name, std::string path,
                SourcePosition key_place);

void add_members(const toml::table& table, Value& value) {
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    value.children.push_back(converted(
        node, name, value.path.empty() ? name : value.path + "." + name, place_of(key.source())));
  }
  // The parser sorts by name; the file's order is the one that people see.
  std::ranges::stable_sort(value.children, {}, [](const Value& child) {
    return std::pair(child.key_place.line, child.key_place.column);
  });
}

void add_elements(const toml::array& array, Value& value) {
  value.children.reserve(array.size());
  for (std::size_t i = 0; i < array.size(); ++i) {
    const std::string name = fmt::format("[{}]", i);
    value.children.push_back(
        converted(array[i], name, value.path + name, place_of(array[i].source())));
  }
}

Value converted(const toml::node& node, std::string name, std::string path,
                SourcePosition key_place) {
  Value value{.name = std::move(name),
              .path = std::move(path),
              .key_place = key_place,
              .place = place_of(node.source()),
              .last_line = static_cast<int>(node.source().end.line)};
  if (const toml::table* table = node.as_table()) {
    add_members(*table, value);
  } else if (const toml::array* array = node.as_array()) {
    value.kind = Value::Kind::list;
    add_elements(*array, value);
  } else if (const auto* flag = node.as_boolean()) {
    value.kind = Value::Kind::flag;
    value.flag = flag->get();
  } else if (const auto* whole = node.as_integer()) {
    value.kind = Value::Kind::whole;
    value.number = static_cast<double>(whole->get());
  } else if (const auto* number = node.as_floating_point()) {
    value.kind = Value::Kind::number;
    value.number = number->get();
  } else if (const auto* text = node.as_string()) {
    value.kind = Value::Kind::text;
    value.text = text->get();
  } else {
    value.kind = Value::Kind::date;
  }
  return value;
}

/// Letters to change, add, leave out or swap with their neighbour to turn `a` into `b`.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  std::iota(above.begin(), above.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above.back();
}

void mark_inherited(Value& value) {
  value.inherited = true;
  for (Value& child : value.children) mark_inherited(child);
}

/// Adds what the file that `extends` names has at the top and the document has not.
void inherit(Document& document, const Value& extends) {
  const std::filesystem::path name(extends.text);
  if (extends.kind != Value::Kind::text || name.empty() || name != name.filename() || name == "..")
    document.mismatch(extends, "the name of a scene file beside this one");
  document.base = document.file.parent_path() / name;
  std::string text;
  try {
    text = read_regular_file(document.base, kMaxBytes, "a scene file");
  } catch (const BadAsset& error) {
    document.fail(extends, error.what());
  }
  const Document base = parse_document(document.base, text);
  if (const Value* again = base.root.find("extends"))
    base.fail(*again, fmt::format("{} extends this file, which must stand for itself",
                                  document.file.filename().string()));
  for (const Value& value : base.root.children) {
    if (value.name == "plan" || document.root.find(value.name)) continue;
    mark_inherited(document.root.children.emplace_back(value));
  }
}

}  // namespace

const Value* Value::find(std::string_view member) const {
  const auto found = std::ranges::find(children, member, &Value::name);
  return found == children.end() ? nullptr : &*found;
}

std::string shown(const Value& value) {
  switch (value.kind) {
    case Value::Kind::flag:
      return value.flag ? "true" : "false";
    case Value::Kind::whole:
    case Value::Kind::number:
      return fmt::format("{}", value.number);
    case Value::Kind::text: {
      constexpr std::size_t longest = 40;
      // Bytes that continue a character (10xxxxxx) are not cut from it.
      std::size_t end = std::min(value.text.size(), longest);
      while (end < value.text.size() && (value.text[end] & 0xC0) == 0x80) ++end;
      return fmt::format("\"{}{}\"", value.text.substr(0, end),
                         end < value.text.size() ? "..." : "");
    }
    case Value::Kind::date:
      return "a date";
    case Value::Kind::list:
      return fmt::format("a list of {}", value.children.size());
    case Value::Kind::table:
      return "a table";
  }
  return {};
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& known) {
  if (word.size() > 64) return {};
  std::string_view best;
  std::size_t least = std::max<std::size_t>(word.size() / 3, 1) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edits(word, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best.empty() ? "" : fmt::format(", did you mean \"{}\"?", best);
}

void Document::fail(const Value& value, const std::string& message) const {
  fail_place(value.inherited ? base : file, value.place,
             value.path.empty() ? message : fmt::format("{}: {}", value.path, message));
}

void Document::fail_at_key(const Value& value, const std::string& message) const {
  fail_place(value.inherited ? base : file, value.key_place,
             value.path.empty() ? message : fmt::format("{}: {}", value.path, message));
}

void Document::mismatch(const Value& value, const std::string& expected) const {
  fail(value, fmt::format("found {}, expected {}", shown(value), expected));
}

Document read_document(const std::filesystem::path& file) {
  std::string text;
  try {
    text = read_regular_file(file, kMaxBytes, "a scene file");
  } catch (const BadAsset& error) {
    throw BadScene(error.what());
  }
  Document document = parse_document(file, text);
  if (const Value* extends = document.root.find("extends")) inherit(document, *extends);
  return document;
}

Document parse_document(const std::filesystem::path& file, std::string_view text) {
  check_dots(file, text);
  try {
    const toml::table table = toml::parse(text);
    return {file, converted(table, "", "", SourcePosition{})};
  } catch (const toml::parse_error& error) {
    fail_place(file, place_of(error.source()),
               fmt::format("not a TOML file: {}", error.description()));
  }
}

void change(Document& document, std::string_view path, const std::string& text) {
  Value* table = &document.root;
  std::string_view rest = path;
  for (;;) {
    const std::size_t dot = rest.find('.');
    const std::string name(rest.substr(0, dot));
    if (table->kind != Value::Kind::table) {
      document.fail(*table, fmt::format("is no table, so that {} cannot be set", path));
    }
    auto at = std::ranges::find(table->children, name, &Value::name);
    if (at == table->children.end()) {
      const std::string full = table->path.empty() ? name : table->path + "." + name;
      table->children.push_back({.name = name, .path = full, .key_place = {}, .place = {}});
      at = table->children.end() - 1;
    }
    table = &*at;
    if (dot == std::string_view::npos) break;
    rest.remove_prefix(dot + 1);
  }
  try {
    const toml::table parsed = toml::parse("value = " + text);
    *table = converted(*parsed.get("value"), table->name, table->path, table->key_place);
  } catch (const toml::parse_error& error) {
    document.fail(*table, fmt::format("{} is no value: {}", text, error.description()));
  }
}

}  // namespace taut
