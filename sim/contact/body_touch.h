// Free bodies that touch: how they respond to what pulls them, a place at which one touches
// something, those that touch each other, and what may touch at all.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/contact/touch.h"
#include "sim/links/mechanism.h"
#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::contact {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

inline constexpr std::uint32_t kNoBody = UINT32_MAX;  // in the place of a body's number

/// A twist is a velocity of the centre of mass and a spin; or the rates of both.
Vec3 velocity_at(const Vec6& twist, const Vec3& arm);

/// An impulse at a point of a body, as its twist meets it: the impulse, and its moment.
Vec6 wrench(const Vec3& impulse, const Vec3& arm);

/// The change of a body's twist per impulse, from its inverse mass and inertia in world axes.
Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia);

/// The change (m/s, or 1/kg) of a point's velocity per impulse at another point of the body.
Mat3 mobility(const Mat6& twists, const Vec3& arm, const Vec3& pulled);

/// How each of many bodies responds to a pull: by itself, or together with those that it touches.
class BodyMobility {
 public:
  /// Each by itself.
  void set_apart(std::span<const Mat6> own);
  /// These together: by rows, how the twist of one changes under what pulls at another.
  void set(std::span<const std::uint32_t> bodies, std::span<const Mat6> blocks);

  std::size_t size() const { return own_.size(); }
  /// To what pulls at the body itself.
  const Mat6& own(std::size_t body) const { return own_[body]; }
  /// Whether a pull at one may move the other.
  bool meet(std::size_t a, std::size_t b) const {
    return a == b || (place_[a].count > 0 && place_[a].first == place_[b].first);
  }
  /// How one that meets the other moves under what pulls at that.
  const Mat6& between(std::size_t moved, std::size_t pulled) const {
    if (moved == pulled) return own_[moved];
    return blocks_[place_[moved].first + place_[moved].index * place_[moved].count +
                   place_[pulled].index];
  }
  /// All that a pull at the body moves, itself included.
  std::span<const std::uint32_t> moved_with(const std::uint32_t& body) const {
    const Place& at = place_[body];
    return at.count > 0 ? std::span(&bodies_[at.listed], at.count) : std::span(&body, 1);
  }

 private:
  struct Place {  // of a body among those that it touches; count 0: it touches none
    std::size_t first = 0, index = 0, count = 0, listed = 0;
  };
  std::vector<Mat6> own_, blocks_;
  std::vector<Place> place_;
  std::vector<std::uint32_t> bodies_;  // those that touch others
};

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

/// Notes what it gives, in that state.
void set(BodyTouch& at, Touch::State state, const Vec3& given);

/// Divides bodies into clusters: the impulse of one touch may change all of its cluster, and
/// nothing else. A body that touches no other is a cluster of its own.
class Clusters {
 public:
  void find(std::size_t bodies, std::span<const BodyTouch> touches);

  /// The body that a cluster is numbered by: the first of it.
  std::uint32_t of(std::uint32_t body) const { return root_[body]; }
  std::uint32_t of(const BodyTouch& at) const { return root_[at.body]; }

  /// Calls it with the first touch of each cluster and how many it has, of touches in order of
  /// their clusters.
  template <typename Visit>
  void each(std::span<const BodyTouch> touches, const Visit& visit) const {
    for (std::size_t first = 0, end = 0; first < touches.size(); first = end) {
      while (end < touches.size() && of(touches[end]) == of(touches[first])) ++end;
      visit(first, end - first);
    }
  }

 private:
  std::uint32_t first_of(std::uint32_t body);

  std::vector<std::uint32_t> root_;
};

/// A free body whose capsule may touch an obstacle or, as a solid that moves with it, the capsule
/// of another. Free bodies are numbered among themselves, as Mechanism does.
struct BodyMeeting {
  std::uint32_t body = 0, other = kNoBody;  // kNoBody: an obstacle
  std::uint32_t obstacle = 0;               // of no account where there is another body
  Shape shape;                              // of what it touches
  Pose place;  // of the shape: in the axes of the other body, from its centre of mass
  double static_friction = 0, kinetic_friction = 0, restitution = 0;
};

/// The capsules of all free bodies, from their centres of mass.
std::vector<BodyCapsule> capsules_of_free_bodies(const World& world);

/// Adds those of a body, or of what stands for one, with the obstacles that its category touches.
void add_meetings(std::uint32_t body, std::uint64_t category, std::span<const Obstacle> obstacles,
                  std::vector<BodyMeeting>& meetings);

/// All that these may touch, in order of the bodies; `pairs` of the world's bodies.
std::vector<BodyMeeting> meetings_of_bodies(const World& world, std::span<const Obstacle> obstacles,
                                            std::span<const BodyPair> pairs);

/// The same of beads that may touch free bodies, as `pairs` says, and that nothing holds: `body` is
/// the mechanism's point that stands for the bead.
std::vector<BodyMeeting> meetings_of_beads(const World& world, const Mechanism& mechanism,
                                           std::span<const BeadPair> pairs);

/// Per free body, the number of those that may touch each other in whatever way; empty where no
/// body may touch another.
std::vector<std::uint32_t> bodies_together(std::span<const BodyMeeting> meetings,
                                           std::size_t bodies);

/// Where the solid is that another body is, which has that centre of mass and rotation.
Pose pose_of_solid(const BodyMeeting& meeting, const Vec3& centre, const Quat& rotation);

}  // namespace taut::contact
