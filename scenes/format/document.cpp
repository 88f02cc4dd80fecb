#include "scenes/format/document.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <numeric>

#include "scenes/files/error.h"
#include "scenes/files/files.h"

namespace taut::scenes {

namespace {

constexpr std::size_t kMaxBytes = 16 << 20;
// The parser makes one nested table of each dotted part, and frees them recursively.
constexpr int kMaxDots = 64;

std::string name_of(const std::filesystem::path& file) {
  return file == kStandardInput ? "standard input" : file.string();
}

[[noreturn]] void fail_place(const std::filesystem::path& file, SourcePosition place,
                             const std::string& key, const std::string& fault) {
  const std::string message = key.empty() ? fault : fmt::format("{}: {}", key, fault);
  throw SceneFault(fmt::format("{}:{}:{}: {}", name_of(file), place.line, place.column, message),
                   {name_of(file), place.line, place.column, key, fault});
}

/// At a value of the document: those that stand in no file have no line.
[[noreturn]] void fail_value(const Document& document, const Value& value, SourcePosition place,
                             const std::string& fault) {
  if (value.place.line > 0) {
    fail_place(value.inherited ? document.base : document.file, place, value.path, fault);
  }
  const std::string file = name_of(document.file);
  throw SceneFault(fmt::format("{}: {} as set: {}", file, value.path, fault),
                   {file, 0, 0, value.path, fault});
}

void check_dots(const std::filesystem::path& file, std::string_view text) {
  int line = 1, dots = 0;
  for (const char c : text) {
    if (c == '.') {
      if (++dots > kMaxDots) {
        fail_place(file, {line, 1}, "",
                   fmt::format("more than {} dots in a row of words", kMaxDots));
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
  fail_value(*this, value, value.place, message);
}

void Document::fail_at_key(const Value& value, const std::string& message) const {
  fail_value(*this, value, value.key_place, message);
}

void Document::mismatch(const Value& value, const std::string& expected) const {
  fail(value, fmt::format("found {}, expected {}", shown(value), expected));
}

std::string read_scene_text(const std::filesystem::path& file) {
  try {
    if (file != kStandardInput) return read_regular_file(file, kMaxBytes, "a scene file");
    static const std::string input = read_standard_input(kMaxBytes, "a scene file");
    return input;
  } catch (const BadAsset& error) {
    throw BadScene(error.what());
  }
}

Document read_document(const std::filesystem::path& file) {
  Document document = parse_document(file, read_scene_text(file));
  if (const Value* extends = document.root.find("extends")) inherit(document, *extends);
  return document;
}

void fail_at(const std::filesystem::path& file, const std::vector<std::string>& keys,
             const std::string& message) {
  std::error_code none;
  if (file != kStandardInput && !std::filesystem::exists(file, none)) {  // a scene that is no file
    throw BadScene(fmt::format("{}: {}", file.string(), message));
  }
  const Document document = read_document(file);
  const Value* last = &document.root;
  for (const std::string& key : keys) {
    const Value* next = last->find(key);
    if (!next) break;
    last = next;
  }
  document.fail(*last, message);
}

Document parse_document(const std::filesystem::path& file, std::string_view text) {
  check_dots(file, text);
  try {
    const toml::table table = toml::parse(text);
    return {file, converted(table, "", "", SourcePosition{})};
  } catch (const toml::parse_error& error) {
    fail_place(file, place_of(error.source()), "",
               fmt::format("not a TOML file: {}", error.description()));
  }
}

namespace {

/// The parts of a dotted path; elements of lists are parts of their own.
std::vector<std::string> parts_of(std::string_view path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[') {
      parts.emplace_back();
    } else if (c != ']') {
      parts.back() += c;
    }
  }
  return parts;
}

/// Text that TOML has no value of but that people write for a word, as assets/stick.glb.
bool is_word(std::string_view text) {
  return !text.empty() && text.find_first_of("\"'[]{}=,#\n\r\t") == std::string_view::npos;
}

/// Marks a value as changed: a value that stands in no file has no line.
void mark_changed(Value& value) {
  value.place = value.key_place = {0, 0};
  for (Value& child : value.children) mark_changed(child);
}

/// The member or element of that name; a table gets a new one where it has none.
Value& member_of(const Document& document, Value& value, const std::string& name,
                 std::string_view path) {
  if (value.kind == Value::Kind::list) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
    if (error == std::errc() && end == name.data() + name.size() && index < value.children.size()) {
      return value.children[index];
    }
    document.fail(value, fmt::format("has {} elements, so that {} cannot be set",
                                     value.children.size(), path));
  }
  if (value.kind != Value::Kind::table) {
    document.fail(value, fmt::format("is no table, so that {} cannot be set", path));
  }
  const auto at = std::ranges::find(value.children, name, &Value::name);
  if (at != value.children.end()) return *at;
  const std::string full = value.path.empty() ? name : value.path + "." + name;
  value.children.push_back({.name = name, .path = full, .key_place = {0, 0}, .place = {0, 0}});
  return value.children.back();
}

}  // namespace

void change(Document& document, std::string_view path, const std::string& text) {
  Value* value = &document.root;
  for (const std::string& part : parts_of(path)) value = &member_of(document, *value, part, path);
  const auto put = [&](const std::string& toml) {
    const toml::table parsed = toml::parse("value = " + toml);
    *value = converted(*parsed.get("value"), value->name, value->path, value->key_place);
    mark_changed(*value);
  };
  try {
    put(text);
  } catch (const toml::parse_error& error) {
    if (!is_word(text)) {
      document.fail(*value, fmt::format("{} is no value: {}", text, error.description()));
    }
    value->kind = Value::Kind::text;
    value->text = text;
    value->children.clear();
    mark_changed(*value);
  }
}

}  // namespace taut::scenes
