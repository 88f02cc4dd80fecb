// Numbers drawn from a seed, the same on every machine.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "sim/motion/types.h"

namespace taut {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967296.0;
  }
  /// Log-uniform.
  double scale(double low, double high) { return low * std::pow(high / low, between(0, 1)); }
  /// One of `count` choices.
  int pick(int count) { return static_cast<int>(between(0, count)); }
  double radians(double low, double high) { return between(low, high) * std::numbers::pi / 180; }

  /// In a cube, or a box, of these half sides.
  Vec3 within(double half) {
    const double x = between(-half, half), y = between(-half, half), z = between(-half, half);
    return {x, y, z};
  }
  Vec3 within(const Vec3& half) {
    const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
    return half.cwiseProduct(Vec3(x, y, z));
  }
  /// A unit vector, no direction likelier than another.
  Vec3 direction() {
    const double y = between(-1, 1), azimuth = between(0, 2 * std::numbers::pi);
    const double across = std::sqrt(1 - y * y);
    return {across * std::cos(azimuth), y, across * std::sin(azimuth)};
  }

 private:
  std::mt19937 random_;
};

}  // namespace taut
