// How a bead responds to what it touches: unilateral contact with Coulomb friction, solved at one
// bead; how friction at many is approached; and what an impact throws back.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
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

/// Coulomb's coefficient where it would slip so.
inline double friction_of(const Touch& touch, const Vec3& slip) {
  return touch.sliding.dot(slip) > 0 ? touch.slide : touch.stick;
}

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

// Newton's method.

/// The creep of what sticks, see respond().
inline constexpr double kCreep = 1e-14;

inline constexpr int kIterations = 80;  // of Newton's method, at most

/// The share of Newton's changes that is taken: all as long as touches stay as they are. Touches
/// that change their state to and fro, between sticking and sliding say, need less. Where a change
/// of states travels along a connector, a relaxation takes it there.
class Damping {
 public:
  /// Call once in an iteration, with a number of the states that the touches are in. Whether to
  /// relax the rows one by one, rather than to take a share() of Newton's change.
  bool relaxes(std::uint64_t pattern) {
    const bool changed = pattern != last_;
    last_ = pattern;
    if (++iteration_ <= kUndamped) return changed && iteration_ % kRelaxed == 0;
    share_ = changed ? std::max(0.1, 0.7 * share_) : std::min(1.0, 2 * share_);
    return changed && iteration_ % kRelaxed == 0;
  }
  double share() const { return share_; }

 private:
  static constexpr int kUndamped = 6, kRelaxed = 4;

  int iteration_ = 0;
  double share_ = 1;
  std::uint64_t last_ = 0;
};

// What an impact throws back, so that it makes no energy.

/// Kinetic energies (J) of what an impact moves: before it; after it as Newton's law has it, and
/// without restitution; and half of the product of both velocities after it with the masses.
struct ImpactEnergies {
  double before = 0, thrown = 0, stopped = 0, mixed = 0;
};

/// Of a rebound by Newton's law less than this share of the energy before is gained by rounding.
inline constexpr double kGainedByRounding = 1e-10;

inline bool gains_energy(double before, double thrown) {
  return thrown > (1 + kGainedByRounding) * before;
}

/// The largest share with which `thrown` velocities, and with the rest `stopped` ones, have no more
/// energy than before. Without restitution none is gained, so there is one.
inline double share_thrown_back(const ImpactEnergies& energy) {
  const double square = energy.stopped - 2 * energy.mixed + energy.thrown;
  const double half = energy.mixed - energy.stopped, spare = energy.before - energy.stopped;
  if (!(spare > 0) || !(square > 0)) return 0;
  // The larger root, without cancellation.
  const double root = std::sqrt(half * half + square * spare);
  return half > 0 ? spare / (half + root) : (root - half) / square;
}

}  // namespace taut::contact
