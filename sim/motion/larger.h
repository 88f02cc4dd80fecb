// The larger of two numbers where one may be nan.
#pragma once

namespace taut {

/// The larger of two numbers, and nan where one is: std::max() may hide it.
inline double larger(double a, double b) {
  return b > a || b != b ? b : a;
}

}  // namespace taut
