// Checks JSON by the part of JSON Schema (draft 7) that this project's schemas use.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace taut {

class JsonSchema {
 public:
  explicit JsonSchema(nlohmann::json schema) : root_(std::move(schema)) {}

  /// The fault of a value by the definition of that name; empty: none.
  std::string complaint(const nlohmann::json& value, const std::string& definition) const {
    return look(value, root_.at("$defs").at(definition), definition);
  }

 private:
  using Json = nlohmann::json;

  static bool is(const Json& value, const std::string& type) {
    return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
           (type == "string" && value.is_string()) || (type == "boolean" && value.is_boolean()) ||
           (type == "null" && value.is_null()) || (type == "number" && value.is_number()) ||
           (type == "integer" && value.is_number_integer());
  }

  std::string look(const Json& value, const Json& schema, const std::string& at) const {
    if (schema.contains("$ref")) {
      const std::string name = schema.at("$ref").get<std::string>().substr(8);
      return look(value, root_.at("$defs").at(name), at);
    }
    if (schema.contains("anyOf")) {
      std::string all;
      for (const Json& one : schema.at("anyOf")) {
        const std::string wrong = look(value, one, at);
        if (wrong.empty()) return {};
        all += wrong + "; ";
      }
      return all;
    }
    if (schema.contains("enum")) {
      const Json& all = schema.at("enum");
      if (std::find(all.begin(), all.end(), value) == all.end()) return at + ": " + value.dump();
    }
    if (schema.contains("type")) {
      const Json types = schema.at("type").is_array() ? schema.at("type") : Json{schema.at("type")};
      if (std::none_of(types.begin(), types.end(), [&](const Json& t) { return is(value, t); }))
        return at + ": " + value.dump().substr(0, 60) + " is not of " + types.dump();
    }
    if (value.is_array() && schema.contains("items"))
      for (std::size_t i = 0; i < value.size(); ++i)
        if (auto wrong = look(value[i], schema.at("items"), at + "[" + std::to_string(i) + "]");
            !wrong.empty())
          return wrong;
    return value.is_object() ? members(value, schema, at) : "";
  }

  std::string members(const Json& value, const Json& schema, const std::string& at) const {
    for (const Json& key : schema.value("required", Json::array()))
      if (!value.contains(key.get<std::string>())) return at + ": lacks " + key.dump();
    const Json properties = schema.value("properties", Json::object());
    const Json others = schema.value("additionalProperties", Json(true));
    for (const auto& [key, member] : value.items()) {
      const std::string path = at + "." + key;
      if (properties.contains(key)) {
        if (auto wrong = look(member, properties.at(key), path); !wrong.empty()) return wrong;
      } else if (others == false) {
        return path + ": is no key of the schema";
      } else if (others.is_object()) {
        if (auto wrong = look(member, others, path); !wrong.empty()) return wrong;
      }
    }
    return {};
  }

  Json root_;
};

}  // namespace taut
