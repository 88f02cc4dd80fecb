// Free bodies at obstacles and at each other, in a step of ContactStep.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/body_meetings.h"
#include "sim/contact/body_system.h"
#include "sim/contact/clusters.h"
#include "sim/links/mechanism.h"
#include "sim/world/obstacle.h"

namespace taut::direct {

/// A twist in a state of a Mechanism.
inline contact::Vec6 twist_at(const double* u) {
  return Eigen::Map<const contact::Vec6>(u);
}

/// The touches of bodies' capsules. In the first stage of a step they hold for the mean velocities
/// of the axes' points and the mean spin, and give half of their impulses where the step begins and
/// half where it ends; in the second for the velocities at its end. As a bead does, each body
/// responds by itself, or with those that it touches (BodySystem).
class BodyTouches {
 public:
  /// A step, of which the bodies' poses and twists are known where it begins.
  struct Step {
    const Mechanism& mechanism;
    const std::vector<Obstacle>& obstacles;
    std::span<const FrameMotion> start, end;  // of the obstacles
    const std::vector<double>& state;         // at the start
    double time = 0, h = 0, touching = 0;     // s, s, m
  };
  struct Hit {
    double share = 1;           // of the step
    std::uint32_t meeting = 0;  // of what may touch
    unsigned spots = 0;         // a bit each
    bool passes = false;        // the body is outside again at the step's end
  };

  void rebuild(const World& world, std::span<const Obstacle> obstacles,
               std::span<const BodyPair> pairs);
  /// Of bodies that may touch each other, see contact::bodies_together().
  std::vector<std::uint32_t> together() const {
    return contact::bodies_together(meetings_, capsules_.size());
  }
  /// Whether some body may touch something.
  bool possible() const { return !meetings_.empty(); }
  bool any() const { return !touches_.empty(); }
  const std::vector<contact::BodyTouch>& touches() const { return touches_; }
  /// Takes these for the touches of the step before.
  void follow(const std::vector<contact::BodyTouch>& touches) { touches_ = touches; }
  /// m, from a body's centre of mass to the farthest point of its capsule; 0: it has none.
  double bounding_radius(std::size_t body) const { return bounding_radius_[body]; }

  /// Finds the bodies that touch where the step begins, those that leave aside. Whether one gets
  /// there only then, to be thrown back faster than `least` (m/s).
  bool find(const Step& step, double least);
  /// The obstacles and bodies hit on the way to `next`. Empty: none.
  const std::vector<Hit>& hits(const Step& step, const std::vector<double>& next);
  const std::vector<Hit>& found() const { return hits_; }  // by the last hits()
  /// Whether two bodies of those found meet within a share of the step.
  bool meet_within(double share) const;
  /// Whether something of those found within a share of the step is thrown back.
  bool thrown_back_within(double share) const;
  void add(const Step& step, const Hit& hit);

  // The first stage.
  void scale_friction(double share);
  void release();  // nothing has been given
  /// Tells them where bodies end up; returns the most that one of these turns (rad).
  double aim(const Step& step, const std::vector<double>& next);
  /// Finds what is given so that bodies which `move` takes to `next` obey the laws. False: nothing.
  template <typename Move>
  bool respond(const Step& step, std::span<const Mat3> inverse, const std::vector<double>& next,
               double creep, const Move& move) {
    double before = 1;
    for (int i = 0; i < kRounds; ++i) {
      move();
      double change = 0;
      if (!solve_means(step, inverse, next, creep, change)) return false;
      if (change <= kUnchanged || (change < kHardly && change > before / 2)) break;
      before = change;
    }
    return true;
  }
  /// Adds half of what is given to `twists` of bodies with such poses and inverse inertias.
  void kick(const Mechanism& mechanism, const std::vector<double>& poses,
            std::span<const Mat3> inverse, std::vector<double>& twists) const;
  /// By how much (m) a touch is open or broken, or its body elsewhere than aimed at.
  double residual(const std::vector<double>& next, const Mechanism& mechanism) const;

  // The second stage.
  /// Bounces slower than `least` (m/s) are not followed.
  void aim_velocities(const Step& step, const std::vector<double>& next, double least);
  bool rebounds() const;  // whether some body is thrown back
  void stop_bounces();    // none is
  /// The twists at the end, from those in `next`, which links have changed. False: none was found.
  bool settle(const Mechanism& mechanism, const std::vector<double>& next, double creep);
  /// The part of a body's twist that settle() adds.
  const contact::Vec6& added(std::size_t body) const { return twists_[body]; }

  /// How bodies respond to pulls, of the last respond() or settle(); null: freely.
  const contact::BodyMobility* coupled() const { return any() ? &coupled_ : nullptr; }
  std::uint64_t pattern() const;

 private:
  static constexpr int kRounds = 30;
  static constexpr double kUnchanged = 1e-15, kHardly = 1e-12;  // of what is given

  struct Side {                // of a body at a touch
    Vec3 at = Vec3::Zero();    // m, on its axis; body axes from the centre of mass, at the end
    Vec3 mean = Vec3::Zero();  // the same, of the mean over the step
    Vec3 down = Vec3::Zero();  // m, from the axis to the surface
  };
  struct Place {  // of a touch, beside what BodySystem sees
    bool hits = false;
    double gap = 0;          // m, at the end
    double bounce = 0;       // m/s, in the second stage
    double along_start = 0;  // of the axis
    Vec3 start_normal = Vec3::Zero();
    Vec3 other_start = Vec3::Zero();  // as Side::at, of the other body at the start
    Side own, other;
    Vec3 before = Vec3::Zero();  // N s, of the first stage
  };
  /// Where what a body may touch is, if other bodies are where `state` says.
  Pose solid(const contact::BodyMeeting& meeting, std::span<const FrameMotion> frames,
             const Mechanism& mechanism, const std::vector<double>& state) const;
  /// The velocity of a body's surface past what it touches, where the step begins.
  Vec3 passing_at_start(const Step& step, const contact::BodyTouch& at) const;
  void aim_arms(const contact::Capsule& own, const contact::SpotGap& near,
                const Mechanism& mechanism, const std::vector<double>& state,
                contact::BodyTouch& at) const;
  /// The place on the other body's axis that is nearest, in its axes from its centre of mass.
  Vec3 foot(const contact::BodyMeeting& meeting, const contact::Capsule& own,
            const contact::SpotGap& near, const double* pose) const;
  /// m, by how much a body's material at a touch moves in the step.
  static Vec3 way(const double* from, const double* to, const Vec3& at);
  Vec3 mean_velocity(const Step& step, const std::vector<double>& next, std::uint32_t body,
                     const Side& side) const;

  void add(const Step& step, std::uint32_t meeting, contact::Spot spot, bool hits);
  void gather();
  void free_mobilities(const Mechanism& mechanism, std::span<const Mat3> inverse);
  contact::Capsule capsule(const double* pose, std::size_t body) const;
  bool is_known(std::uint32_t meeting, std::size_t spot) const;
  Hit sweep(const Step& step, const std::vector<double>& next, std::uint32_t meeting) const;
  bool solve_means(const Step& step, std::span<const Mat3> inverse, const std::vector<double>& next,
                   double creep, double& change);
  void aim_velocity(const Step& step, std::size_t touch, const std::vector<double>& next);
  void now_free(const Mechanism& mechanism);
  double arriving(const Step& step, std::size_t touch, const Vec3& own,
                  const std::vector<double>& next) const;

  std::vector<BodyCapsule> capsules_;  // per free body, from its centre of mass
  std::vector<double> bounding_radius_;
  std::vector<contact::BodyMeeting> meetings_;
  std::vector<contact::BodyTouch> touches_, before_;  // in order of clusters; of the step before
  contact::Clusters clusters_;
  std::vector<Place> places_;            // per touch
  std::vector<double> aimed_;            // per body with touches: its pose at aim()
  std::vector<contact::Mat6> mobility_;  // per body, by itself
  contact::BodyMobility coupled_;
  std::vector<contact::Vec6> twists_;  // per body: what touches add in the second stage
  std::vector<contact::Vec6> moves_;   // per body
  std::vector<Vec3> bare_, last_;      // m/s, N s
  std::vector<Hit> hits_;
  contact::BodySystem system_;
};

}  // namespace taut::direct
