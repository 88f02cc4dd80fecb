// How a bead responds to what it touches: unilateral contact with Coulomb friction, solved at one
// bead.
#pragma once

#include <span>

#include "sim/motion/types.h"

namespace taut::contact {

/// A surface at a bead, in one stage of a step. Impulses are over the bead's mass, so that they are
/// velocities (m/s).
struct Touch {
  enum class State { open, slides, sticks };
  Vec3 normal = Vec3::UnitY();  // out of the surface
  double least = 0;             // m/s: the bead's velocity along the normal is at least that
  Vec3 surface = Vec3::Zero();  // m/s, of the obstacle there
  double stick = 0, slide = 0;  // Coulomb's coefficients, static and kinetic
  /// m/s, how the bead slid before. Static friction holds a bead that was at rest, or comes to rest
  /// before it goes on the other way.
  Vec3 sliding = Vec3::Zero();

  /// The bead's impulses from the surface earlier in the step, contained in the `free` velocity of
  /// respond(): along the normal, and by friction. Signorini and Coulomb hold for the sum.
  Vec3 pushed = Vec3::Zero(), friction_before = Vec3::Zero();

  // Found by respond():
  State state = State::open;
  double push = 0;               // along the normal, the sum
  Vec3 friction = Vec3::Zero();  // across it, the sum
};

/// A bead's velocity and how it changes with the velocity that it would have without the touches.
struct Response {
  Vec3 velocity = Vec3::Zero();
  Mat3 derivative = Mat3::Identity();
};

/// The velocity of a bead that would have `free`, and at most three touches: along each normal it
/// is at least Touch::least, a surface pushes only where it equals that, and friction is within
/// Coulomb's cone and, where the bead slides, against its sliding (kinetic). Where two surfaces
/// hold a bead, friction acts along their common line alone: of many solutions this one needs no
/// friction across it.
///
/// A bead that sticks creeps: friction takes 1/(1 + creep) of its slip, so that different pulls
/// always move it differently, be it by rounding alone.
Response respond(const Vec3& free, std::span<Touch> touches, double creep = 0);

/// How the velocity of a bead changes as the normal and the least velocity of its one closed touch
/// do; `normal` and `least` are their derivatives by anything in three dimensions.
Mat3 response_to_turning(const Vec3& free, const Touch& touch, const Mat3& normal,
                         const Vec3& least, double creep);

}  // namespace taut::contact
