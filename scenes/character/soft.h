// Shapes of costs and limits that the parts of a character share.
#pragma once

#include <algorithm>
#include <cmath>

namespace taut::scenes {

inline constexpr double degree = M_PI / 180;  // rad

inline double squared(double x) {
  return x * x;
}
/// How far a value is beyond its limit; 0 below it.
inline double beyond(double value, double limit) {
  return std::max(0.0, value - limit);
}
/// From 0 to 1 as x does, with level ends.
inline double smoothstep(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
/// x for small values, which approaches the limit for large ones.
inline double soft(double x, double limit) {
  return limit * std::tanh(x / limit);
}

}  // namespace taut::scenes
