// Links at obstacles, in a step of ContactStep.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/contact/touch.h"
#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/glide_system.h"

namespace taut::direct {

/// The touches of links between their beads. A touch at a share s of the way from one bead to the
/// next moves with (1 - s) of the one's velocity and s of the other's, and what the link gets there
/// goes to both in these shares. It obeys the laws of beads (touch.h), as one of the mass with
/// which it moves. Beads respond to it as to the pulls of their links: its impulse is an unknown of
/// Newton's method beside these. In the first stage of a step a touch that lasts gives along the
/// mean of its normals and at the mean of its shares; in the second where the step ends.
class LinkTouches {
 public:
  using Step = BodyTouches::Step;
  struct Hit {
    double share = 1;  // of the step
    std::uint32_t link = 0, obstacle = 0;
    contact::Spot spot = contact::Spot::nearest;
    bool passes = false;  // the link is outside again at the step's end
    Vec3 anchor, side;    // m, and the normal: where it enters, in the obstacle's frame
  };

  struct LinkTouch {
    std::uint32_t link = 0, obstacle = 0;
    contact::Spot spot = contact::Spot::nearest;
    bool hits = false;       // it came to be in this step
    Vec3 anchor, side;       // m, and the normal there: where it began, in the obstacle's frame
    double share_start = 0;  // of the way to the next point, where the step begins
    Vec3 normal_start;       // out of the obstacle, there
    double share = 0;        // where it gives
    double gap = 0;          // m, at the end
    double mobility = 1;     // 1/kg, of the link there
    double bounce = 0;       // m/s, in the second stage
    contact::Touch touch = {};
    Vec3 given = Vec3::Zero();   // N s, of this stage; in the first, of the mean velocities
    Vec3 kicked = Vec3::Zero();  // N s: of that, what free bodies have got
    Vec3 error = Vec3::Zero();   // m/s
    Mat3 derivative = Mat3::Identity();
  };

  void rebuild(const World& world, const Mechanism& mechanism);
  /// Whether some link may touch something.
  bool possible() const { return !links_.empty(); }
  bool any() const { return !touches_.empty(); }

  /// Finds the links that touch where the step begins, those that leave aside. Whether one gets
  /// there only then, to be thrown back faster than `least` (m/s).
  bool find(const Step& step, double least);
  /// What links hit on the way to `next`, on which points have such mean velocities.
  const std::vector<Hit>& hits(const Step& step, const std::vector<double>& next,
                               std::span<const Vec3> mean);
  const std::vector<Hit>& found() const { return hits_; }  // by the last hits()
  void add(const Step& step, const Hit& hit);

  void scale_friction(const std::vector<Obstacle>& obstacles, double share);
  void release();  // nothing has been given in this stage
  void keep();     // what has been given
  void restore();

  /// Tells the touches of the first stage where the links end up.
  void aim(const Step& step, const std::vector<double>& next);
  /// Whether a touch that lasts is at the other end of what lies flat than where it began: that end
  /// arrives within the step, and what is given between both would do work.
  bool tips(const Step& step, const std::vector<double>& next) const;

  /// Tells the touches of the second stage where they are, and what the first has given; bounces
  /// slower than `least` (m/s) are not followed.
  void aim_velocities(const Step& step, const std::vector<double>& next,
                      std::span<const Vec3> middle, double least, bool located);

  bool rebounds() const;  // whether some link is thrown back
  void stop_bounces();    // none is

  /// Adds what is given to the velocities of points; those that free bodies carry are left to
  /// these.
  void give(std::span<const double> inverse_mass, std::span<Vec3> velocity) const;
  /// Gives free bodies that carry a bead of a touch what it gets of that, in `twists` of a state,
  /// with their `arm` (per body point) and `inverse` inertias.
  void kick(const Mechanism& mechanism, std::span<const Vec3> arm, std::span<const Mat3> inverse,
            std::vector<double>& twists) const;
  /// The same where the mechanism has been placed, of what they have not got yet.
  void kick_more(const Mechanism& mechanism, std::vector<double>& twists);
  void take_back_kicks();  // they have got nothing
  /// Nonlinear Gauss-Seidel, once to and fro: each touch in turn gives what its law asks for.
  /// `bare` are the velocities of points without their own touches, to which respond(point) answers
  /// with a `velocity`.
  template <typename Respond>
  void relax(std::span<const double> inverse_mass, std::span<Vec3> bare,
             std::span<const Vec3> velocity, double creep, const Respond& respond) {
    const auto relax_one = [&](LinkTouch& at) {
      const std::uint32_t point = links_[at.link].first;
      if (is_carried(at)) return;  // the body responds to all that it gets
      find_error(at, velocity, creep);
      const Vec3 more = at.error / at.mobility;
      at.given += more;
      bare[point] += (1 - at.share) * inverse_mass[point] * more;
      bare[point + 1] += at.share * inverse_mass[point + 1] * more;
      respond(point);
      respond(point + 1);
    };
    for (LinkTouch& at : touches_) relax_one(at);
    for (std::size_t i = touches_.size() - 1; i-- > 0;) relax_one(touches_[i]);
  }
  /// Whether there is one touch alone, which relax() gives what its law asks for exactly.
  bool is_one() const { return count() == 1 && !is_carried(touches_[0]); }
  /// How touches respond, and by how much they break their laws, as points move with `velocity`.
  void find_errors(std::span<const Vec3> velocity, double creep);
  /// m/s: by how much a touch breaks its law, as of find_errors(), beyond the `noise` of points.
  double error(std::span<const double> noise) const;

  /// Newton's equations of the touches after find_errors(), and by how much these fall short.
  void linearize();
  /// The same in the first stage, as links go elsewhere from where they are, which their points
  /// with such velocities are `behind` of.
  void linearize(const Step& step, const std::vector<double>& next, std::span<const Vec3> velocity,
                 std::span<const Vec3> behind, double creep);
  std::span<const GlideSystem::LinkTouch> linear() const { return linear_; }
  std::span<Vec3> missing() { return missing_; }
  /// Adds a share of what Newton's method has made of missing().
  void advance(double share);

  /// m, by how much a touch is open or broken.
  double residual() const;
  /// m/s, by friction: of what sticks.
  double most_stuck() const;
  std::uint64_t pattern() const;
  std::size_t count() const { return touches_.size(); }
  const std::vector<LinkTouch>& touches() const { return touches_; }
  /// Takes these for the touches of the step before.
  void follow(const std::vector<LinkTouch>& touches) { touches_ = touches; }
  /// The first bead of a touch's link; touches are in order of these.
  std::uint32_t first(std::size_t touch) const { return links_[touches_[touch].link].first; }

 private:
  struct Link {
    std::uint32_t first = 0;  // point; the other is the next
    double radius = 0;        // m
    std::uint64_t category = 0;
    std::array<std::uint32_t, 2> carried;  // of both, as Mechanism::body_points() has it; or kNone
    std::vector<contact::Spot> spots;      // where it touches
  };
  static constexpr std::uint32_t kNone = UINT32_MAX;
  bool is_carried(const LinkTouch& at) const {
    const auto& carried = links_[at.link].carried;
    return carried[0] != kNone || carried[1] != kNone;
  }
  double mobility(const Mechanism& mechanism, const Link& link, std::size_t end) const;
  void kick(const Mechanism& mechanism, const LinkTouch& at, std::size_t end, const Vec3& given,
            const Vec3& arm, const Mat3& inverse, std::vector<double>& twists) const;
  contact::Capsule capsule(const Step& step, const std::vector<double>& state,
                           std::uint32_t link) const;
  Vec3 velocity(const Step& step, std::uint32_t link, double share) const;
  bool is_known(std::uint32_t link, std::uint32_t obstacle, contact::Spot spot) const;
  void add(const Step& step, LinkTouch made);
  void aim(LinkTouch& at, const Step& step, const contact::Capsule& own) const;
  void set_mobility(LinkTouch& at, const Step& step) const;
  void find_error(LinkTouch& at, std::span<const Vec3> velocity, double creep);
  double arriving(const LinkTouch& at, const Step& step, std::span<const Vec3> middle) const;
  void bend(const Step& step, const std::vector<double>& next, const LinkTouch& at,
            std::span<const Vec3> velocity, double creep, GlideSystem::LinkTouch& made) const;
  void sweep(const Step& step, const std::vector<double>& next, std::span<const Vec3> mean,
             std::uint32_t link, std::uint32_t obstacle);

  std::vector<Link> links_;
  std::vector<LinkTouch> touches_, before_;  // in order of links; before_: of the step before
  std::vector<Hit> hits_;
  std::vector<Vec3> kept_, missing_;  // N s, m/s
  std::vector<GlideSystem::LinkTouch> linear_;
};

}  // namespace taut::direct
