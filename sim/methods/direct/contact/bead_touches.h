// Beads at free bodies, in a step of ContactStep.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/body_meetings.h"
#include "sim/contact/touch.h"
#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/glide_system.h"

namespace taut::direct {

/// The touches of beads and the capsules of free bodies. What a bead gets there its body gets the
/// other way, where their surfaces meet; it obeys the law of a bead (touch.h) for the velocity past
/// the body, as one of the mass with which both move. Beads and bodies respond to it as to pulls of
/// links: its impulse is an unknown of Newton's method beside these, as of links (LinkTouches). In
/// the first stage of a step it holds for the displacements over the step, along the mean of its
/// normals for a touch that lasts, and the body gets half of it where the step begins and half
/// where it ends; in the second it holds for the velocities at the end.
class BeadTouches {
 public:
  using Step = BodyTouches::Step;
  struct Hit {
    double share = 1;           // of the step
    std::uint32_t meeting = 0;  // of what may touch
    bool passes = false;        // the bead is outside again at the step's end
    Vec3 anchor, side;          // m, and the normal: where it enters, in the body's axes
  };

  struct BeadTouch {
    std::uint32_t point = 0, body = 0, meeting = 0;
    bool hits = false;  // it came to be in this step
    Vec3 anchor, side;  // m, and the normal there: where it began, in the body's axes
    Vec3 normal_start;  // out of the body, where the step begins
    double gap = 0;     // m, at the end
    Vec3 foot, down;    // m: on the body's axis at the end, in its axes; from there to the surface
    Vec3 place;         // m: of the foot, as it was aimed at
    Vec3 start_arm, arm;  // m, from the centre of mass: where it gives, at the start and the end
    double mobility = 1;  // 1/kg, of both along the normal
    double bounce = 0;    // m/s, in the second stage
    contact::Touch touch = {};
    Vec3 given = Vec3::Zero();   // N s, of this stage; in the first, of the mean velocities
    Vec3 kicked = Vec3::Zero();  // N s: of that, what the body has got
    Vec3 free = Vec3::Zero();    // m/s: past the body, without what is given
    Vec3 error = Vec3::Zero();   // m/s
    Mat3 derivative = Mat3::Identity();
  };

  /// `pairs` of the world's connectors and bodies touch each other.
  void rebuild(const World& world, const Mechanism& mechanism, std::span<const BeadPair> pairs);
  /// Whether some bead may touch a body.
  bool possible() const { return !meetings_.empty(); }
  bool any() const { return !touches_.empty(); }

  /// Finds the beads that touch where the step begins, those that leave aside. Whether one gets
  /// there only then, to be thrown back faster than `least` (m/s).
  bool find(const Step& step, double least);
  /// What beads hit on the way to `next`, where they have such mean velocities.
  const std::vector<Hit>& hits(const Step& step, const std::vector<double>& next,
                               std::span<const Vec3> mean);
  const std::vector<Hit>& found() const { return hits_; }  // by the last hits()
  /// Whether a bead of those found meets a body within a share of the step.
  bool meet_within(double share) const {
    return std::ranges::any_of(hits_, [&](const Hit& hit) { return hit.share <= share; });
  }
  /// Whether something of those found within a share of the step is thrown back.
  bool thrown_back_within(double share) const;
  void add(const Step& step, const Hit& hit);

  void scale_friction(double share);
  void release();  // nothing has been given in this stage
  void keep();     // what has been given
  void restore();

  /// Tells the touches of the first stage where beads and bodies end up; returns the most that one
  /// of these bodies turns (rad).
  double aim(const Step& step, const std::vector<double>& next);
  /// Tells the touches of the second stage where they are, and what the first has given; bounces
  /// slower than `least` (m/s) are not followed.
  void aim_velocities(const Step& step, const std::vector<double>& next,
                      std::span<const Vec3> middle, double least, bool located);
  bool rebounds() const;  // whether some bead is thrown back
  void stop_bounces();    // none is

  /// Adds what is given to the velocities of points.
  void give(std::span<const double> inverse_mass, std::span<Vec3> velocity) const;
  /// Gives the bodies, of these `inverse` inertias, what they get of it where the step begins.
  void kick(const Mechanism& mechanism, std::span<const Mat3> inverse,
            std::vector<double>& twists) const;
  /// The same at the end, where the mechanism has been placed, of what they have not got yet.
  void kick_more(const Mechanism& mechanism, std::vector<double>& twists);
  void take_back_kicks();  // they have got nothing

  /// How touches respond, and by how much they break their laws, as points move with such mean
  /// velocities and bodies to `next`.
  void find_errors(const Step& step, const std::vector<double>& next, std::span<const Vec3> mean,
                   double creep);
  /// The same of velocities; `twists` of a state, with what `added` has per body.
  void find_errors(const Mechanism& mechanism, std::span<const Vec3> velocity,
                   const std::vector<double>& twists, const BodyTouches& added, double creep);
  /// m/s: by how much a touch breaks its law, beyond the `noise` of points.
  double error(std::span<const double> noise) const;

  /// Newton's equations of the touches after find_errors(), and by how much these fall short.
  void linearize();
  /// The same in the first stage, as beads go elsewhere from where they are, which points are
  /// `behind` of.
  void linearize(const Step& step, const std::vector<double>& next, std::span<const Vec3> behind,
                 double creep);
  std::span<const GlideSystem::BeadTouch> linear() const { return linear_; }
  std::span<Vec3> missing() { return missing_; }
  /// Adds a share of what Newton's method has made of missing().
  void advance(double share);

  /// m, by how much a touch is open or broken, or its body elsewhere than aimed at.
  double residual(const Mechanism& mechanism, const std::vector<double>& next) const;
  /// m/s, by friction: of what sticks.
  double most_stuck() const;
  std::uint64_t pattern() const;
  std::size_t count() const { return touches_.size(); }
  /// In order of points.
  const std::vector<BeadTouch>& touches() const { return touches_; }
  /// Takes these for the touches of the step before.
  void follow(const std::vector<BeadTouch>& touches) { touches_ = touches; }

 private:
  contact::SpotGap gap_of(const contact::BodyMeeting& meeting, std::uint32_t index,
                          const Vec3& bead, const double* pose) const;
  bool is_far(const Step& step, std::uint32_t meeting, double near) const;
  bool is_known(std::uint32_t meeting) const;
  Vec3 passing_at_start(const Step& step, const BeadTouch& at) const;
  void add(const Step& step, BeadTouch made);
  void aim(BeadTouch& at, const Step& step, const double* pose, const Vec3& to) const;
  void set_mobility(BeadTouch& at, const Mechanism& mechanism) const;
  void find_error(BeadTouch& at, const Vec3& past, double creep);
  double arriving(const BeadTouch& at, const Mechanism& mechanism, const Vec3& past,
                  const Vec3& before, const Vec3& given) const;
  void sweep(const Step& step, const std::vector<double>& next, std::span<const Vec3> mean,
             std::uint32_t index);

  std::vector<contact::BodyMeeting> meetings_;
  std::vector<double> radius_;  // per meeting, m: of the bead
  std::vector<double> reach_;   // per meeting, m: from the centre of mass; no bead beyond touches
  std::vector<double> bounding_radius_;      // per body, m
  std::vector<BeadTouch> touches_, before_;  // before_: of the step before
  std::vector<Hit> hits_;
  std::vector<Vec3> kept_, missing_;  // N s, m/s
  std::vector<GlideSystem::BeadTouch> linear_;
};

}  // namespace taut::direct
