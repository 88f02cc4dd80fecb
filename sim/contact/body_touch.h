// A place at which a free body touches something.
#pragma once

#include <span>

#include "sim/contact/body_mobility.h"
#include "sim/contact/capsule.h"
#include "sim/contact/touch.h"

namespace taut::contact {

/// A place at which a body touches an obstacle or another body, which gets the opposite of what is
/// given; velocities are past that. The touch gives impulses (N s), and Touch::pushed and
/// Touch::friction_before are not used.
struct BodyTouch {
  std::uint32_t body = 0, other = kNoBody;  // kNoBody: an obstacle
  std::uint32_t meeting = 0;                // of what may touch, see meetings_of_bodies()
  Spot spot = Spot::from;
  Vec3 arm = Vec3::Zero();  // m, from the centre of mass to where it touches, world axes
  double share = 0;         // of a link: of the way from one bead to the next
  Vec3 other_arm = Vec3::Zero();
  Touch touch;
  /// The way in which it slides already, whatever moves it; zero: it may stick.
  Vec3 ahead = Vec3::Zero();
  Vec3 given = Vec3::Zero();  // N s, found by solve()
};

/// The velocity of a touch where bodies move so: of its body past the other, if there is one.
Vec3 passing(std::span<const Vec6> twists, const BodyTouch& at);

/// The projector on the plane across a normal.
inline Mat3 across(const Vec3& normal) {
  return Mat3::Identity() - normal * normal.transpose();
}

/// Coulomb's coefficient where it would slip so.
inline double friction_of(const Touch& touch, const Vec3& slip) {
  return touch.sliding.dot(slip) > 0 ? touch.slide : touch.stick;
}

/// Notes what it gives, in that state.
void set(BodyTouch& at, Touch::State state, const Vec3& given);

}  // namespace taut::contact
