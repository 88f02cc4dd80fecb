// What may touch in a world, and where it does: beads, links and free bodies at obstacles and at
// free bodies, and links at links.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/links/mechanism.h"
#include "sim/run/forces.h"
#include "sim/world/world.h"

namespace taut::direct {

/// Two things that may touch: a bead, the capsule of a link or the capsule of a free body at an
/// obstacle or at the capsule of another free body; or a bead or a link at a bead or a link. A
/// capsule may touch at several spots, of which each is a candidate. Two links touch between their
/// ends, or an end of one touches the other between its ends, or two ends touch.
struct Candidate {
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::uint32_t a = kNone, b = kNone;  // points: of a bead a == b, of a link its ends
  std::uint32_t c = kNone, d = kNone;  // points: the same of a bead or link that it may touch
  std::uint32_t body = kNone;          // of the mechanism, whose capsule it is
  contact::Spot spot = contact::Spot::from;
  bool is_bead() const { return a == b && a != kNone; }
  bool is_at_rope() const { return c != kNone; }
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // m: of a body's capsule, from its centre of mass
  double radius = 0;                            // m; with that of the other bead or link
  std::uint32_t obstacle = kNone, other = kNone;
  Shape shape = {};  // of the obstacle or of the other body
  Pose place = {};   // of the shape in the other body's axes, from its centre of mass
  double stick = 0, slide = 0, restitution = 0;
};

/// Where a candidate is, and how it moves.
struct Meeting {
  double gap = 0;                 // m, of the surfaces; negative: one is inside the other
  Vec3 normal = Vec3::UnitY();    // out of the obstacle, of the other body or link
  double share = 0;               // of a link: of the way from a to b
  double other_share = 0;         // of the way from c to d
  Vec3 arm = Vec3::Zero();        // m, from the body's centre of mass to the touching point
  Vec3 other_arm = Vec3::Zero();  // m, the same of the other body
  Vec3 local = Vec3::Zero();  // m, of the bead's centre or the capsule's axis, in the shape's axes
  Mat3 turn = Mat3::Identity();  // from those axes
  Vec3 surface = Vec3::Zero();   // m/s, of an obstacle there
};

class Touches {
 public:
  /// Lists all candidates of a world. `mechanism` is laid out for it.
  void rebuild(const World& world, const Mechanism& mechanism);

  /// The two sides of a candidate, in the indices of the world.
  std::pair<Forces::Side, Forces::Side> sides(std::size_t candidate) const;
  /// The radius (m) of a point's connector.
  double radius(std::uint32_t point) const { return radius_[point]; }
  bool any() const { return !candidates_.empty() || links_.any(); }
  /// All that were near once: a candidate keeps its index.
  const std::vector<Candidate>& candidates() const { return candidates_; }

  /// Finds the candidates that may touch before a point has moved by half of `within` (m). The
  /// state must be placed.
  void find_near(const Mechanism& mechanism, const std::vector<double>& state, double within);
  /// Whether near() holds all that may touch in a state.
  bool are_near_known(const Mechanism& mechanism, const std::vector<double>& state) const;
  /// The largest distance (m) that a point, or a point of a free body's capsule, has between two
  /// states.
  double largest_move(const Mechanism& mechanism, const std::vector<double>& one,
                      const std::vector<double>& other) const;
  /// Indices of candidates, rising.
  const std::vector<std::uint32_t>& near() const { return near_; }

  /// Puts obstacles where they are at `time` (s). The world must be that of rebuild().
  void place(const World& world, double time);
  /// Where a candidate is in a placed state of the mechanism.
  Meeting meet(const Mechanism& mechanism, std::size_t candidate, const double* state) const;
  /// How the normal changes with the point (1/m); of two links, with one past the other.
  Mat3 curvature(std::size_t candidate, const Meeting& at) const;
  /// The axis (m) of a capsule, from one end to the other; of a bead 0.
  Vec3 axis(const Mechanism& mechanism, const Candidate& of, const double* state) const;
  /// Whether the spot of a capsule is a point of its own there.
  bool is_distinct(const Mechanism& mechanism, std::size_t candidate, const double* state) const;
  /// The velocity (m/s) of the candidate past what it may touch.
  Vec3 passing(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
               const double* state) const;

 private:
  /// The axes of what a candidate may touch, in the world's.
  struct Axes {
    Vec3 origin;  // m
    Mat3 turn;
  };
  Axes axes_of(const Mechanism& mechanism, const Candidate& of, const double* state) const;
  Pose frame_of(const Mechanism& mechanism, const Candidate& of, const double* state) const;
  static contact::Capsule capsule_of(const Mechanism& mechanism, const Candidate& of,
                                     const double* state);

  bool is_between(const Mechanism& mechanism, std::uint32_t bead, std::uint32_t a, std::uint32_t b,
                  const double* state) const;
  bool are_links_distinct(const Mechanism& mechanism, const Candidate& of,
                          const double* state) const;
  Meeting meet_links(const Mechanism& mechanism, const Candidate& of, const double* state) const;
  void add_pair(const contact::LinkPair& pair);
  void add_near(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                const contact::LinkPair& pair);

  std::vector<Candidate> candidates_;
  std::size_t fixed_ = 0;            // of these, those of other than two links; they stand first
  std::vector<char> on_moving_;      // of these, whether at an obstacle that moves
  std::vector<FrameMotion> frames_;  // of the obstacles
  std::vector<Mat3> turns_;          // their rotations
  contact::NearLinks links_;
  std::vector<ConnectorPair> rules_;
  std::vector<double> radius_;                // m, of each point's connector
  std::vector<Forces::Side> particles_;       // of points
  std::vector<std::size_t> free_;             // bodies of the mechanism, in World::bodies
  std::vector<std::uint32_t> leader_;         // of each point
  std::vector<char> moves_;                   // per point: it is free, or a free body carries it
  std::vector<std::uint32_t> next_, former_;  // per leader: its neighbours, or kNone
  std::unordered_map<std::uint64_t, std::uint32_t> known_;  // candidates of two links
  std::vector<contact::LinkPair> pairs_;
  std::vector<std::uint32_t> near_;
  std::vector<double> near_at_;  // the state of find_near()
  double within_ = -1;           // m; negative: not known
  std::vector<double> reach_;    // m, per free body: of its capsule
};

}  // namespace taut::direct
