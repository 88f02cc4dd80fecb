// What brings skin to surfaces: distances between them, their cost, and a search that lowers costs.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "scenes/character/capsules.h"
#include "scenes/character/digit.h"

namespace taut::scenes {

inline constexpr double mm = 0.001;
inline constexpr double skin_gap = 0.7 * mm;  // left between skin and what it touches

/// A cost of some numbers that compass search can lower: tries each up and down, and halves the
/// stride when nothing helps. `cost(x, enough)` may stop where it comes to `enough`, which is too
/// much.
template <std::size_t n, typename Cost>
double descend(std::array<double, n>& x, Cost cost, double stride = 0.3, double finest = 0.004) {
  double least = cost(x, std::numeric_limits<double>::infinity());
  while (stride > finest) {
    bool better = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (const double sign : {1.0, -1.0}) {
        std::array<double, n> y = x;
        y[i] += sign * stride;
        const double trial = cost(y, least);
        if (trial < least) {
          x = y;
          least = trial;
          better = true;
        }
      }
    }
    if (!better) stride /= 2;
  }
  return least;
}

/// The cost of a gap (m) between the skin and the surface to touch; penetration costs more.
double touch(double gap);

/// Distance of a point from a capsule's surface; negative inside, m.
double distance(const Vec3& p, const Capsule& c);

/// Distance of a part of the skin from capsules, where it is less than `most` (m).
double gap(const BentSkin& bent, std::size_t part, std::span<const Capsule> things,
           double most = std::numeric_limits<double>::infinity());

}  // namespace taut::scenes
