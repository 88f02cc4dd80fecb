// Results as JSON: numbers are numbers, with their units in their keys, and what there is none of
// is null. results.schema.json describes them all.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace taut::program {

using Json = nlohmann::ordered_json;

inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace taut::program
