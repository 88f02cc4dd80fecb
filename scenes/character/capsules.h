// A character as capsules, one per bone, fitted to its skin: for clearance from what flies past.
#pragma once

#include <vector>

#include "scenes/model/model.h"

namespace taut::scenes {

/// All points within `radius` (m) of the segment from `a` to `b` (m).
struct Capsule {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
  double radius = 0;
  std::size_t bone = 0;  // that it moves with
};

/// Capsules in the bind pose, in the model's space. Each holds nearly all the vertices that move
/// mostly with its bone or with cloth that hangs on it; a bone with hardly any has none.
std::vector<Capsule> fit_capsules(const Model& model);

/// The capsules where `bones` (world poses, order of Model::bones) carry them.
std::vector<Capsule> place_capsules(const std::vector<Capsule>& fitted, const Model& model,
                                    const std::vector<Pose>& bones);

/// Distance of a point from a segment, m.
double point_distance(const Vec3& p, const Vec3& a, const Vec3& b);

/// Distance between two segments, m.
double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1);

/// Distance between two capsules' surfaces; negative where they overlap, m.
double clearance(const Capsule& a, const Capsule& b);

}  // namespace taut::scenes
