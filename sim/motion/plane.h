// Worlds that move in one vertical plane, and the models that this spares.
#pragma once

#include <optional>
#include <span>

#include "sim/motion/types.h"

namespace taut {

/// Two unit vectors along a plane and the normal n = x cross y.
struct Plane {
  Vec3 x, y, normal;

  /// Whether `v` leaves the plane by no more than rounding.
  bool holds(const Vec3& v) const {
    constexpr double kRounding = 1e-11;
    const double off = v.dot(normal);
    return off * off <= kRounding * kRounding * v.squaredNorm();
  }
};

/// The plane of `vectors` (any lengths, zeros ignored), or none. Where they all lie along one line,
/// the plane contains `hints` as far as one of them leaves the line.
std::optional<Plane> common_plane(std::span<const Vec3> vectors, std::span<const Vec3> hints);

}  // namespace taut
