// Contact shadows: what is near a surface takes ambient light from it, as feet from the floor.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "scenes/character/capsules.h"
#include "scenes/scene/stage.h"
#include "sim/motion/types.h"

namespace taut::draw {

/// How far a capsule's contact shadow reaches from its axis, in radii.
constexpr double kContactRange = 6;

struct ContactCapsule {
  Vec3 from, to;  // m, the ends of its axis
  double radius;  // m

  /// Around everything that it darkens.
  Eigen::AlignedBox3f bounds() const;
};

/// The feet of a character whose bones have these poses: its soles, and its toes.
std::vector<ContactCapsule> feet(const scenes::Model& character, const std::vector<Pose>& bones);

/// The shins of a character whose bones have these poses.
std::vector<ContactCapsule> shins(const scenes::Model& character, const std::vector<Pose>& bones);

/// The arms of a character in its bind pose, which darken its trunk (scenes::place_capsules).
std::vector<scenes::Capsule> arms(const scenes::Model& character);

/// A body's model along its longest side, in the body's frame; none where it is not twice as long
/// as it is wide.
std::optional<ContactCapsule> rod(const scenes::Model& model);

}  // namespace taut::draw
