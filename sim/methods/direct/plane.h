// Worlds that move in one vertical plane, and the models that this spares.
#pragma once

#include <optional>
#include <span>

#include "sim/types.h"

namespace taut::direct {

/// Two unit vectors along a plane and the normal n = x cross y.
struct Plane {
  Vec3 x, y, normal;

  /// Whether `v` leaves the plane by more than rounding.
  bool holds(const Vec3& v) const { return std::abs(v.dot(normal)) <= 1e-11 * v.norm(); }
};

/// The plane of `vectors` (any lengths, zeros ignored), or none. Where they all lie along one line,
/// the plane contains `hints` as far as one of them leaves the line.
std::optional<Plane> common_plane(std::span<const Vec3> vectors, std::span<const Vec3> hints);

}  // namespace taut::direct
