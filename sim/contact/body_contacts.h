// Contacts of free bodies: candidate pairs, the response of bodies to impulses, and contact
// solved one after another for `xpbd` and `springs`.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/contact/touch.h"
#include "sim/links/mechanism.h"
#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::contact {

// Free bodies that touch: how they respond to what pulls them, a place at which one touches
// something, those that touch each other, and what may touch at all.

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

/// The masses (kg) that a touch meets, of all bodies that it is between: impulses over the changes
/// of velocity that they make there.
struct EffectiveMass {
  double along = 0;            // the normal
  Mat3 across = Mat3::Zero();  // the normal: of the impulse that makes a change across it
  double least_across = 0;     // what is so light in no way
};
EffectiveMass effective_mass(std::span<const Mat6> mobility, const BodyTouch& at);

/// Projected Gauss-Seidel, as in Jean, The non-smooth contact dynamics method, 1999, and in games:
/// each touch in turn takes the push that makes its velocity Touch::least, or none, and friction
/// that stops it or is against its sliding. What static friction does not stop slides with the
/// kinetic one. Starts at BodyTouch::given, which `twists` (of all bodies) contain; `masses`
/// of each touch. Velocities and impulses (m/s, N s) may be displacements and what makes them
/// (m, kg m).
///
/// A body that lies on two points keeps the fourth part of the error in each sweep; sweeps end
/// where they change little, and after a fixed number, which is less than a high pile needs.
void relax(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists);

/// For methods of fixed steps on a Mechanism, after the step, as ConnectorContacts; each body moves
/// by its own mass, whatever links hold it. Where bodies are together, or one has several touches,
/// relax() finds what they do to each other. A bead that may touch a body (World::bead_pairs) is
/// one without a size: a ball that does not turn.
class BodyContacts {
 public:
  /// Call when the topology is new.
  void rebuild(const Mechanism& mechanism, const World& world);

  bool any() const { return !meetings_.empty(); }

  /// Moves bodies out, and against their sliding since the places of `before`, as far as Coulomb's
  /// law lets what moved them out.
  void move_out(const Mechanism& mechanism, double time, double dt,
                const std::vector<double>& before, std::vector<double>& state);
  /// After move_out(), with the velocities that positions made: completes what that gave to the
  /// impulses of the step, with the restitution of the speeds that touches came with, in `before`.
  /// So friction in an impact is of the impulse, and no depth gives a velocity. True where there
  /// was an impact, so that links may have to answer.
  bool rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
               std::vector<double>& state);
  /// Completes the impulses again where links have changed velocities since. True where that
  /// changes them by less than a millionth.
  bool push(const Mechanism& mechanism, std::vector<double>& state);

  /// Moves bodies out along normals, and finds the impulses that stop or throw back the velocities
  /// of what touches, with friction.
  void stop(const Mechanism& mechanism, double time, double dt, std::vector<double>& state);

 private:
  /// What may touch: free bodies, as Mechanism numbers them, and behind them beads.
  std::size_t bodies() const { return capsules_.size() - beads_.size(); }
  Pose pose_of(const Mechanism& mechanism, std::uint32_t one,
               const std::vector<double>& state) const;
  Vec6 twist_of(const Mechanism& mechanism, std::uint32_t one,
                const std::vector<double>& state) const;
  void set_twist(const Mechanism& mechanism, std::uint32_t one, const Vec6& twist,
                 std::vector<double>& state) const;
  Mat6 mobility_of(const Mechanism& mechanism, std::uint32_t one,
                   const std::vector<double>& state) const;
  Vec3 moved(const Mechanism& mechanism, std::uint32_t one, const Vec3& arm,
             const std::vector<double>& before, const std::vector<double>& state) const;

  void find(const Mechanism& mechanism, double time, double dt, const std::vector<double>& state);
  void find_at(const Mechanism& mechanism, std::size_t meeting, double near,
               const std::vector<double>& state);
  Pose solid_of(const Mechanism& mechanism, const BodyMeeting& meeting,
                const std::vector<double>& state) const;
  void add_beads(const World& world, std::span<const BodyMeeting> meetings);
  std::uint32_t number_here(std::uint32_t one);
  void add(const Mechanism& mechanism, std::size_t meeting, const Capsule& capsule, Spot spot,
           const SpotGap& gap, const std::vector<double>& state);
  void find_masses(const Mechanism& mechanism, const std::vector<double>& state);
  void shift(const Mechanism& mechanism, std::vector<double>& state);
  bool find_rebounds(const Mechanism& mechanism, double dt, const std::vector<double>& came);
  void use_friction(bool used);
  Vec3 surface_velocity(const BodyTouch& at) const;

  /// Meetings of beads with one body, in a row.
  struct BeadGroup {
    std::size_t first = 0, end = 0;
    double reach = 0;  // m, from the middle of the body's capsule: no bead farther off touches it
  };

  std::vector<BodyMeeting> meetings_;  // of bodies, then of beads
  std::vector<BeadGroup> groups_;
  std::vector<std::uint32_t> points_;  // of the meetings of beads
  std::vector<BodyCapsule> capsules_;  // from the centre of mass, of all that may touch
  std::vector<std::uint32_t> beads_;   // their points
  std::vector<Obstacle> obstacles_;
  std::vector<FrameMotion> frames_;  // of these, at the step's end
  /// Of numbers_; other_arm: from the obstacle's origin where there is one.
  std::vector<BodyTouch> touches_;
  std::vector<EffectiveMass> masses_;   // per touch
  std::vector<std::uint32_t> numbers_;  // of all that have touches
  std::vector<std::uint32_t> here_;     // where one is among these; kNoBody: it is not
  std::vector<Mat6> mobility_;          // of these
  std::vector<Vec6> twists_;            // of these: displacements, then velocities
};

// How rigid bodies respond to what they touch: unilateral contact with Coulomb friction at several
// points of one body, or of several that touch each other.

/// Bodies that touch each other, or one alone, with all the touches that they have.
class BodySystem {
 public:
  /// `mobility` of all bodies, of which those count that have touches; `share` of the impulses
  /// makes the velocities that solve() speaks of.
  void assemble(std::span<const Mat6> mobility, std::span<const BodyTouch> touches,
                double share = 1);

  /// The same of whatever moves at the touches: its velocities by what is given (1/kg), three rows
  /// and columns a touch; and the inverse mass of each touch, by which errors are measured. Links
  /// may have a part in that, so that nothing moves some touches in some directions.
  void assemble(const Eigen::MatrixXd& coupling, std::span<const double> inverse_mass);

  /// Finds the impulses (or forces) at which the touches obey the laws of touch.h; `bare` (m/s) are
  /// the velocities without. Starts at BodyTouch::given. A touch that sticks creeps with the share
  /// `creep` of the velocity that its friction would give free bodies. False: none found.
  bool solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep);

  /// Finds the impulses if each touch stays open, slides along `ahead` or sticks as its state says.
  void hold(std::span<const Vec3> bare, std::span<BodyTouch> touches);

  /// The derivative of one touch's velocity by another's impulse (1/kg).
  Mat3 coupling(std::size_t i, std::size_t k) const;

  /// The bodies, in the order in which touches name them.
  std::span<const std::uint32_t> bodies() const { return bodies_; }
  /// The twist that `touches` give to one of bodies().
  Vec6 twist(std::span<const BodyTouch> touches, std::size_t index) const;

  /// After solve() or hold(): how the bodies respond to further pulls.
  void couple(std::span<const BodyTouch> touches, BodyMobility& mobility);

 private:
  using Block = Eigen::Matrix<double, 3, 6>;
  /// A body at a touch: its twist makes a part of the touch's velocity. Index kNoBody: none.
  struct Side {
    std::uint32_t index = kNoBody;
    Block lever;
  };

  double held_back(std::size_t touch) const;
  std::uint32_t index_of(std::uint32_t body, std::span<const Mat6> mobility);
  Vec3 velocity(std::size_t i, std::span<const Vec3> bare) const;
  bool solve_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  bool slide_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  void linearize(std::span<const Vec3> bare, std::span<const BodyTouch> touches);
  std::vector<Vec3> solve_linear(std::span<const BodyTouch> touches) const;
  bool goes_on(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool sticks(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool polish(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const;

  std::vector<std::uint32_t> bodies_;
  std::vector<Mat6> mobility_;  // per body of these
  double share_ = 1, creep_ = 0;
  bool several_ = false;  // bodies that touch each other, or what links couple
  bool linked_ = false;
  std::vector<double> inverse_mass_;        // 1/kg, per touch: of the free bodies, shared
  std::vector<std::array<Side, 2>> sides_;  // per touch
  std::vector<Mat6> blocks_;
  Eigen::MatrixXd coupling_;        // 1/kg, of the velocities by what is given, shared
  std::vector<Vec3> given_, bare_;  // N s, m/s
  std::vector<Vec3> tried_;         // N s, what polish() came to last
  // The laws, linearized: matrix_ d(given) = -slope_ d(bare), in multiples of inverse_mass_.
  Eigen::MatrixXd matrix_, slope_;
  Eigen::VectorXd error_;
};

}  // namespace taut::contact
