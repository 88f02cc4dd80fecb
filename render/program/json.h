// Results as JSON: numbers are numbers, with their units in their keys, and what there is none of
// is null. results.schema.json describes them all.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace taut::program {

using Json = nlohmann::ordered_json;

inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// As results are written, indented. Bytes of names that are no UTF-8 become U+FFFD.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace taut::program
