// What may touch in a world, and where it does: beads, links and free bodies at obstacles, at free
// bodies.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut::direct {

/// Two things that may touch: a bead, the capsule of a link or the capsule of a free body at an
/// obstacle or at the capsule of another free body. A capsule may touch at several spots, of which
/// each is a candidate.
struct Candidate {
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::uint32_t a = kNone, b = kNone;  // points: of a bead a == b, of a link its ends
  std::uint32_t body = kNone;          // of the mechanism, whose capsule it is
  contact::Spot spot = contact::Spot::from;
  bool is_bead() const { return a == b && a != kNone; }
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // m: of a body's capsule, from its centre of mass
  double radius = 0;                            // m
  std::uint32_t obstacle = kNone, other = kNone;
  Shape shape = {};  // of the obstacle or of the other body
  Pose place = {};   // of the shape in the other body's axes, from its centre of mass
  double stick = 0, slide = 0, restitution = 0;
};

/// Where a candidate is, and how it moves.
struct Meeting {
  double gap = 0;                 // m, of the surfaces; negative: one is inside the other
  Vec3 normal = Vec3::UnitY();    // out of the obstacle or of the other body
  double share = 0;               // of a link: of the way from a to b
  Vec3 arm = Vec3::Zero();        // m, from the body's centre of mass to the touching point
  Vec3 other_arm = Vec3::Zero();  // m, the same of the other body
  Vec3 local = Vec3::Zero();  // m, of the bead's centre or the capsule's axis, in the shape's axes
  Quat turn = Quat::Identity();  // of those axes
  Vec3 surface = Vec3::Zero();   // m/s, of an obstacle there
};

class Touches {
 public:
  /// Lists all candidates of a world. `mechanism` is laid out for it.
  void rebuild(const World& world, const Mechanism& mechanism);

  bool any() const { return !candidates_.empty(); }
  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Puts obstacles where they are at `time` (s). The world must be that of rebuild().
  void place(const World& world, double time);
  /// Where a candidate is in a placed state of the mechanism.
  Meeting meet(const Mechanism& mechanism, std::size_t candidate, const double* state) const;
  /// How the normal changes with the point (1/m).
  Mat3 curvature(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
                 const double* state) const;
  /// The axis (m) of a capsule, from one end to the other; of a bead 0.
  Vec3 axis(const Mechanism& mechanism, std::size_t candidate, const double* state) const;
  /// Whether the spot of a capsule is a point of its own there.
  bool is_distinct(const Mechanism& mechanism, std::size_t candidate, const double* state) const;
  /// The velocity (m/s) of the candidate past what it may touch.
  Vec3 passing(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
               const double* state) const;

 private:
  Pose frame_of(const Mechanism& mechanism, const Candidate& of, const double* state) const;
  static contact::Capsule capsule_of(const Mechanism& mechanism, const Candidate& of,
                                     const double* state);

  std::vector<Candidate> candidates_;
  std::vector<FrameMotion> frames_;  // of the obstacles
};

}  // namespace taut::direct
