#include "scenes/format/schema.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "scenes/format/format.h"
#include "sim/run/method.h"

namespace taut::scenes {

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
