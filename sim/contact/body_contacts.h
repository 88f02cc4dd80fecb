// Contact of free bodies as games do it: capsules inside of obstacles, of each other or of beads
// are moved out, and rubbed.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/body_touch.h"
#include "sim/links/mechanism.h"

namespace taut::contact {

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

}  // namespace taut::contact
