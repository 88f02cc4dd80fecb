#include "scenes/format/format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/run/method.h"

namespace taut::scenes {
namespace {

using Type = KeyFormat::Type;

std::string range_text(const KeyFormat& key) {
  const bool low = std::isfinite(key.minimum), high = key.maximum < 1e300;
  if (low && high) {
    return key.minimum == key.maximum
               ? fmt::format(": {}", key.minimum)
               : fmt::format(" {} {} {} {}", key.above ? "above" : "from", key.minimum,
                             key.above ? "and at most" : "to", key.maximum);
  }
  if (low) return fmt::format(" {} {}", key.above ? "above" : "of at least", key.minimum);
  if (high) return fmt::format(" of at most {}", key.maximum);
  return "";
}

std::string number_text(const KeyFormat& key) {
  const bool unit = !key.unit.empty() && key.unit != "1";
  return fmt::format("a {}number{}{}", key.whole ? "whole " : "", range_text(key),
                     unit ? fmt::format(" ({})", key.unit) : "");
}

std::string count_text(const KeyFormat& key) {
  if (key.least == key.most) return fmt::format("{}", key.least);
  if (key.most == std::numeric_limits<std::size_t>::max()) {
    return fmt::format("at least {}", key.least);
  }
  return fmt::format("{} to {}", key.least, key.most);
}

/// A flag from 1 on says nothing when it is false.
bool only_true(const KeyFormat& key) {
  return key.minimum == 1;
}

class Checker {
 public:
  /// Throws the first fault or, where there are `faults`, adds all to them.
  explicit Checker(const Document& document, FirstFaults* faults = nullptr)
      : document_(document), faults_(faults) {}

  void table(const Value& value, const TableFormat& format) const {
    expect(value, Value::Kind::table, "a table");
    for (const Value& member : value.children) {
      attempt([&] {
        const KeyFormat* key = format.find(member.name);
        if (!key) unknown(member, format.names());
        check(member, *key);
      });
    }
    for (const KeyFormat& key : format.keys) {
      if (!key.required || value.find(key.name) || is_misspelt(key.name, value, format)) continue;
      attempt([&] {
        document_.fail(value, fmt::format("{} is missing, expected {}", key.name, wanted(key)));
      });
    }
    for (const Alternatives& group : format.alternatives) {
      if (std::ranges::any_of(
              group.keys, [&](std::string_view key) { return is_misspelt(key, value, format); })) {
        continue;
      }
      attempt([&] { check(value, group); });
    }
  }

 private:
  void attempt(auto&& look) const {
    if (!faults_) return look();
    try {
      look();
    } catch (const SceneFault& fault) {
      faults_->add(fault);
    }
  }

  /// True where an unknown member of `value`, a fault of its own, may be meant to be `key`.
  static bool is_misspelt(std::string_view key, const Value& value, const TableFormat& format) {
    return std::ranges::any_of(value.children, [&](const Value& member) {
      return !format.find(member.name) && !suggestion(member.name, {key}).empty();
    });
  }

  static std::string wanted(const KeyFormat& key) {
    switch (key.type) {
      case Type::flag:
        return only_true(key) ? "true, or another key" : "true or false";
      case Type::number:
        return number_text(key);
      case Type::numbers:
        return fmt::format("a list of {} numbers", count_text(key));
      case Type::text:
        return "a string";
      case Type::texts:
        return "a list of strings";
      case Type::file:
        return "the path of a file, as a string";
      case Type::choice:
        return fmt::format("one of: {}", fmt::join(key.choices, ", "));
      case Type::names:
        return fmt::format("a table of strings, or one of: {}", fmt::join(key.choices, ", "));
      case Type::points:
        return fmt::format("a list of {} points [x, y, z]", count_text(key));
      case Type::table:
      case Type::method:
      case Type::named:
        return "a table";
      case Type::tables:
        return key.least > 0 ? fmt::format("a list of {} tables", count_text(key))
                             : "a list of tables";
      case Type::files:
        return "a list of paths of files";
    }
    return {};
  }

  void expect(const Value& value, Value::Kind kind, const std::string& what) const {
    if (value.kind != kind) document_.mismatch(value, what);
  }

  [[noreturn]] void unknown(const Value& member, const std::vector<std::string_view>& known) const {
    const std::string near = suggestion(member.name, known);
    document_.fail_at_key(
        member,
        "is no key of the format" +
            (near.empty() ? fmt::format(", expected one of: {}", fmt::join(known, ", ")) : near));
  }

  void check(const Value& value, const KeyFormat& key) const {
    switch (key.type) {
      case Type::flag:
        expect(value, Value::Kind::flag, wanted(key));
        if (only_true(key) && !value.flag) document_.mismatch(value, wanted(key));
        return;
      case Type::number:
        return number(value, key);
      case Type::numbers:
        count(value, key);
        for (const Value& element : value.children) number(element, key);
        return;
      case Type::text:
        return text(value, wanted(key));
      case Type::texts:
        count(value, key);
        for (const Value& element : value.children) text(element, "a string");
        return;
      case Type::file:
        return file(value, key);
      case Type::choice:
        return choice(value, key);
      case Type::names:
        if (value.kind != Value::Kind::table) return choice(value, key);
        for (const Value& member : value.children) attempt([&] { text(member, "a string"); });
        return;
      case Type::points:
        count(value, key);
        for (const Value& element : value.children) point(element, key);
        return;
      case Type::table:
        return table(value, *key.table);
      case Type::named:
        return named(value, key);
      case Type::tables:
        count(value, key);
        for (const Value& element : value.children) attempt([&] { table(element, *key.table); });
        return;
      case Type::files:
        count(value, key);
        for (const Value& element : value.children) file(element, key);
        return;
      case Type::method:
        return method(value);
    }
  }

  void text(const Value& value, const std::string& what) const {
    expect(value, Value::Kind::text, what);
    if (value.text.find('\0') != std::string::npos) {
      document_.fail(value, "contains a zero byte, expected text");
    }
  }

  void number(const Value& value, const KeyFormat& key) const {
    const double x = value.number;
    const bool low = key.above ? x > key.minimum : x >= key.minimum;
    if (!value.is_number() || !std::isfinite(x) || !low || x > key.maximum ||
        (key.whole && x != std::floor(x))) {
      document_.mismatch(value, number_text(key));
    }
  }

  void count(const Value& value, const KeyFormat& key) const {
    expect(value, Value::Kind::list, wanted(key));
    if (value.children.size() < key.least || value.children.size() > key.most) {
      document_.mismatch(value, wanted(key));
    }
  }

  void point(const Value& value, const KeyFormat& key) const {
    if (value.kind != Value::Kind::list || value.children.size() != 3) {
      document_.mismatch(value, "a point [x, y, z]");
    }
    for (const Value& element : value.children) number(element, key);
  }

  void file(const Value& value, const KeyFormat& key) const {
    expect(value, Value::Kind::text, wanted(key));
    if (value.text.empty() || value.text.find('\0') != std::string::npos) {
      document_.mismatch(value, wanted(key));
    }
  }

  void choice(const Value& value, const KeyFormat& key) const {
    if (value.kind == Value::Kind::text &&
        std::ranges::find(key.choices, value.text) != key.choices.end()) {
      return;
    }
    const std::string near =
        value.kind == Value::Kind::text ? suggestion(value.text, key.choices) : "";
    document_.mismatch(value, wanted(key) + near);
  }

  // Names become columns of CSV files and words of messages.
  void named(const Value& value, const KeyFormat& key) const {
    expect(value, Value::Kind::table, "a table");
    for (const Value& member : value.children) {
      const auto plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-';
      };
      if (member.name.empty() || !std::ranges::all_of(member.name, plain)) {
        document_.fail_at_key(member, "is no name, expected letters, digits, _ and -");
      }
      attempt([&] { table(member, *key.table); });
    }
  }

  void method(const Value& value) const {
    expect(value, Value::Kind::table, "a table");
    const Value* name = value.find("name");
    if (!name) {
      document_.fail(value, "name is missing, expected the name of a method");
    }
    const KeyFormat& choices = method_formats().begin()->second.keys.front();
    choice(*name, choices);
    const TableFormat& format = method_formats().at(name->text);
    for (const Value& member : value.children) {
      if (format.find(member.name)) continue;
      for (const auto& [other, settings] : method_formats()) {
        if (settings.find(member.name)) {
          document_.fail_at_key(member, fmt::format("is a setting of {}, {} takes: {}", other,
                                                    name->text, fmt::join(format.names(), ", ")));
        }
      }
    }
    table(value, format);
  }

  void check(const Value& value, const Alternatives& group) const {
    const Value* first = nullptr;
    for (const Value& member : value.children) {
      if (std::ranges::find(group.keys, member.name) == group.keys.end()) continue;
      if (first) {
        document_.fail_at_key(member, fmt::format("stands beside {}, expected only one of: {}",
                                                  first->name, fmt::join(group.keys, ", ")));
      }
      first = &member;
    }
    if (!first && group.required) {
      document_.fail(value, fmt::format("expected one of: {}", fmt::join(group.keys, ", ")));
    }
  }

  const Document& document_;
  FirstFaults* faults_;
};

}  // namespace

void check_format(const Document& document, const TableFormat& format) {
  check_format(document, document.root, format);
}

void check_format(const Document& document, const Value& table, const TableFormat& format) {
  Checker(document).table(table, format);
}

FirstFaults format_faults(const Document& document) {
  FirstFaults faults;
  Checker(document, &faults).table(document.root, scene_format());
  return faults;
}

namespace {

using Schema = nlohmann::ordered_json;
using Type = KeyFormat::Type;

constexpr std::string_view kExtends = "extends";  // lets another file give what is required

Schema table_schema(const TableFormat& format);

std::string described(const KeyFormat& key) {
  const bool unit = !key.unit.empty() && key.unit != "1";
  return std::string(key.meaning) + (unit ? " [" + std::string(key.unit) + "]" : "");
}

Schema number_schema(const KeyFormat& key) {
  Schema json = {{"type", key.whole ? "integer" : "number"}};
  if (std::isfinite(key.minimum)) json[key.above ? "exclusiveMinimum" : "minimum"] = key.minimum;
  if (key.maximum < 1e300) json["maximum"] = key.maximum;
  return json;
}

Schema list_schema(const KeyFormat& key, Schema items) {
  Schema json = {{"type", "array"}, {"items", std::move(items)}};
  if (key.least > 0) json["minItems"] = key.least;
  if (key.most < std::numeric_limits<std::size_t>::max()) json["maxItems"] = key.most;
  return json;
}

Schema method_schema() {
  Schema by_name = Schema::array();
  for (const auto& [name, format] : method_formats()) {
    Schema one = table_schema(format);
    for (const SettingInfo& setting : find_method(name)->settings) {
      Schema& fallback = one["properties"][std::string(setting.name)]["default"];
      std::visit([&](const auto& value) { fallback = value; }, setting.fallback);
    }
    one["properties"]["name"] = {{"const", name}, {"description", format.keys.front().meaning}};
    by_name.push_back(std::move(one));
  }
  return {{"type", "object"}, {"oneOf", std::move(by_name)}};
}

Schema key_schema(const KeyFormat& key) {
  switch (key.type) {
    case Type::flag:
      return key.minimum == 1 ? Schema{{"type", "boolean"}, {"const", true}}
                              : Schema{{"type", "boolean"}};
    case Type::number:
      return number_schema(key);
    case Type::numbers:
      return list_schema(key, number_schema(key));
    case Type::text:
      return {{"type", "string"}};
    case Type::texts:
      return list_schema(key, {{"type", "string"}});
    case Type::file:
      return {{"type", "string"}, {"minLength", 1}};
    case Type::files:
      return list_schema(key, {{"type", "string"}, {"minLength", 1}});
    case Type::choice:
      return {{"enum", key.choices}};
    case Type::names:
      return {{"anyOf",
               {{{"enum", key.choices}},
                {{"type", "object"}, {"additionalProperties", {{"type", "string"}}}}}}};
    case Type::points:
      return list_schema(
          key,
          {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 3}, {"maxItems", 3}});
    case Type::table:
      return table_schema(*key.table);
    case Type::tables:
      return list_schema(key, table_schema(*key.table));
    case Type::named:
      return {{"type", "object"},
              {"propertyNames", {{"pattern", "^[A-Za-z0-9_-]+$"}}},
              {"additionalProperties", table_schema(*key.table)}};
    case Type::method:
      return method_schema();
  }
  return {};
}

/// Exactly one of the keys; at most one where the group is not required.
Schema group_schema(const Alternatives& group) {
  Schema choices = Schema::array(), any = Schema::array();
  for (const std::string_view key : group.keys) {
    choices.push_back({{"required", {key}}});
  }
  any = choices;
  if (!group.required) choices.push_back({{"not", {{"anyOf", any}}}});
  return {{"oneOf", std::move(choices)}};
}

Schema table_schema(const TableFormat& format) {
  Schema properties = Schema::object(), required = Schema::array(), groups = Schema::array();
  for (const KeyFormat& key : format.keys) {
    Schema& property = properties[std::string(key.name)];
    property["description"] = described(key);
    property.update(key_schema(key));
    if (!key.formerly.empty()) {
      Schema& old = properties[std::string(key.formerly)] = key_schema(key);
      old["description"] = "Deprecated; use `" + std::string(key.name) + "`.";
      old["deprecated"] = true;
    }
    if (key.required) required.push_back(key.name);
  }
  for (const Alternatives& group : format.alternatives) groups.push_back(group_schema(group));
  Schema json = {
      {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (format.find(kExtends)) {  // the other file may have what is required
    groups.push_back(
        {{"anyOf", {{{"required", {kExtends}}}, {{"required", std::move(required)}}}}});
  } else if (!required.empty()) {
    json["required"] = std::move(required);
  }
  if (!groups.empty()) json["allOf"] = std::move(groups);
  return json;
}

}  // namespace

std::string scene_schema() {
  Schema json = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "taut scene"}};
  json.update(table_schema(scene_format()));
  return json.dump(1) + '\n';
}

}  // namespace taut::scenes
