// One step of connectors at obstacles.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/contact/row_system.h"
#include "sim/contact/touch.h"
#include "sim/links/mechanism.h"
#include "sim/methods/direct/contact/bead_touches.h"
#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/glide_system.h"
#include "sim/methods/direct/contact/link_touches.h"
#include "sim/world/obstacle.h"

namespace taut::direct {

/// A step has two stages. In the first, beads glide: with mean velocities and pulls along the mean
/// directions of the links over the step (the midpoint rule in Gonzalez's form, which keeps energy
/// and momenta exactly), all links have their length at its end and no bead is inside of an
/// obstacle, whatever that takes. In the second, velocities settle: impulses along the links and at
/// the touches stop what would stretch a link or enter an obstacle, by Newton's law of impact. Both
/// have Signorini's condition and Coulomb's law for the sum of the step, and are solved by Newton's
/// method, in which each bead responds by itself (see respond()), and each body (BodyTouches). What
/// touches links between their beads (LinkTouches), and beads that touch bodies (BeadTouches), are
/// found beside the links' impulses.
class ContactStep {
 public:
  /// A bead at an obstacle.
  struct BeadTouch {
    std::uint32_t point = 0, obstacle = 0;
    bool hits = false;  // it came to be in this step
    Vec3 anchor, side;  // m, and the normal there: where it began, in the obstacle's frame
    double gap = 0;     // m, at the end
    double bounce = 0;  // m/s, in the second stage
    contact::Touch touch;
  };
  /// What a step leaves to the next.
  struct Past {
    std::vector<double> state, tension;
    std::vector<BeadTouch> touches;
    std::vector<contact::BodyTouch> body_touches;
    std::vector<LinkTouches::LinkTouch> link_touches;
    std::vector<BeadTouches::BeadTouch> bead_touches;
    std::vector<Vec3> along, acceleration, steady;
    std::vector<contact::Vec6> pushed, steady_pushed;
    double h = 0, watched = 0, risen = 0;
    bool hits = true;
    std::uint64_t pattern = 0;
  };

  /// Call when the topology is new; `pairs` of the world's bodies touch each other, and those
  /// connectors and bodies. The obstacles must stay as long as steps are taken.
  void rebuild(const World& world, const std::vector<Obstacle>& obstacles,
               std::span<const BodyPair> pairs, std::span<const BeadPair> bead_pairs);
  /// Reads the state; `world` must stay as long as steps are taken.
  void load(const World& world);
  void store(World& world, double time) const { mechanism_.store(state_, time, world); }

  /// After load(): velocities that links do not allow, as what is done to a world may leave them,
  /// settle in an impact of this moment. Returns how long (s) that took.
  double resolve(double time, double lowest);

  /// s: the longest step in which what damps bends is stable; infinite where nothing does.
  double longest_damped() const { return longest_damped_; }
  /// Two solid things nearer than this (m) touch.
  double touching() const { return touching_; }
  /// Steps from `time` by at most `h` (s); where a bead hits an obstacle on the way and `locates`
  /// is set, to there. Where friction has no solution, a step of at most `slippery` (s) goes with
  /// less. Bounces that would rise less than `lowest` (m) are not followed. Returns how far it
  /// went, zero where the step did not converge. The state is the next one after accept().
  double attempt(double time, double h, double slippery, bool locates, double lowest);
  void accept();
  /// Notes what the next step follows from; goes back to there, as often as one likes: then the
  /// same attempts end in the same bits.
  void note(Past& past) const;
  void go_back(const Past& past);

  // Of the last attempt.
  double turn() const { return turn_; }  // rad, the most that a link turned
  /// Whether a string got to its length: the steps before then tell nothing of those to come.
  bool snaps() const { return snaps_now_; }
  /// Whether the first stage found a solution only with less friction: where jammed beads have none
  /// with all of it (Painleve).
  bool slips() const { return slips_; }
  /// m/s: by how much all is too fast after a step in which touches change, which error() knows
  /// nothing of; 0 also where something is driven.
  double gained() const { return gained_; }
  /// m, RMS, of the first stage; 0: not known. Waves lower
  /// than `lowest` (m) need not be followed.
  double error(double lowest) const;
  std::size_t solves() const { return solves_; }  // since rebuild()
  const Mechanism& mechanism() const { return mechanism_; }
  const std::vector<double>& state() const { return state_; }

 private:
  struct Hit {
    double share = 1;  // of the step
    std::uint32_t point = 0, obstacle = 0;
    bool passes = false;         // the bead is outside again at the step's end
    Vec3 anchor = Vec3::Zero();  // m, where the bead is then, in the obstacle's frame
  };
  /// A string that gets to its length.
  struct Snap {
    double share = 1;  // of the step
    std::size_t row = 0;
  };
  struct EnergyChange {
    double gain = 0, kinetic = 0, mass = 0;  // J in the step, J at its end, kg
  };
  using TouchRange = std::span<BeadTouch>;

  bool is_finite() const;
  double separation_speed(double time);
  bool is_driven() const;
  EnergyChange energy_change() const;
  static double too_fast(const EnergyChange& change);
  void take_gain(const EnergyChange& change);
  bool find_touches(double least);
  double lowest_speed(double lowest) const;
  void add_touch(const Hit& hit, std::size_t sorted);
  bool find_hits(double time, double h);
  Hit sweep(double time, double h, std::uint32_t point, std::uint32_t obstacle) const;
  bool glide(double time, double h);
  bool pull(double time, double h);
  bool pull_creeping(double time, double h, double creep, bool trial = false);
  void respond(double time, double h);
  double residual(double h) const;
  double wave_turn(double h) const;
  void measure();
  void aim(double h);
  void aim(BeadTouch& at, const Vec3& to, double h) const;
  void bend(double h);
  void stiffen(double h);
  void move_bodies(double time, double h);
  bool settle(double time, double h, double least);
  void aim_velocities(double h, double least);
  double arriving(const BeadTouch& at, double h) const;
  bool stop(double stopped);
  void end_settling();
  bool lower_bounces(double stopped);
  double energy_of(const std::vector<double>& one, const std::vector<double>& other) const;
  bool stop_creeping(double stopped, double creep);
  void scale_friction(double share);
  double approach(const std::function<bool(double)>& solve);
  bool with_less_friction(const std::function<bool()>& solve);
  void carry_middle();
  void damp_bends(double h);
  void kick(std::span<const double> impulse, std::span<const Vec3> along, double share);
  void spread(std::span<const double> impulse, std::span<const Vec3> along, double share,
              std::span<Vec3> velocity);
  void respond_all(std::span<Vec3> velocity);
  void respond_at(std::size_t first, std::size_t count, std::span<Vec3> velocity);
  void relax_links(std::span<Vec3> velocity);
  bool couples() const { return links_.any() || beads_.any(); }
  void solve_with_touches(std::span<const Vec3> along, double share);
  void advance_touches(double share);
  void mobilize_carried();
  void carry_held(double h);
  void clear_pulls();
  void keep_pulls();
  void restore_pulls();
  std::span<const BeadTouch> touches_of(std::size_t point) const;
  void relax(std::span<const Vec3> along, double share, std::span<const Vec3> velocity);
  void relax_row(std::size_t row, const Vec3& along, double share);
  bool sticks() const;
  void rebuild_strings();
  void find_taut(bool all);
  bool find_snaps(double h);
  void mean_direction(std::size_t row, const Vec3& gap);
  bool sort_strings(double share);
  void keep_taut();
  double wrong(std::size_t row, double error) const;
  void mask();
  std::uint64_t pattern() const;
  Vec3 position(const std::vector<double>& state, std::size_t point) const;
  BodyTouches::Step body_step(double time, double h) const;
  bool throws_back(double share) const;
  bool take_hits(bool locates, double& h);
  void begin_settling(double time, double h, double least);

  const std::vector<Obstacle>* obstacles_ = nullptr;
  Mechanism mechanism_;
  contact::RowSystem system_;
  GlideSystem glide_system_;
  BodyTouches bodies_;
  LinkTouches links_;
  BeadTouches beads_;
  // Whether what touches links is relaxed in the next evaluation, and in each.
  bool relaxes_ = false, relaxes_all_ = false;
  bool jams_ = false;  // a body has no response to what it touches
  // Per body: the rates of its twist, of the step before, and without waves.
  std::vector<contact::Vec6> pushed_, last_pushed_, steady_pushed_;
  // Per body, m: to the farthest point that touches or holds a link.
  std::vector<double> bounding_radius_;
  double length_ = 0;  // m, of the longest connector
  double touching_ = 0;
  double exact_ = 0;                     // m: roundings of positions
  std::vector<Vec3> damping_;            // N, per point: of what damps bends
  double longest_damped_ = 0;            // s
  std::vector<double> radius_;           // per point, m; negative: it touches nothing
  std::vector<std::uint64_t> category_;  // per point
  std::vector<double> state_, next_;     // as Mechanism has them
  std::vector<double> aimed_, glided_;   // next_ of the last iteration, and after the first stage
  std::vector<BeadTouch> touches_, before_;  // in order of points; before_: of the step before
  std::vector<FrameMotion> start_, end_;     // of the obstacles
  std::vector<Hit> found_;
  std::vector<Vec3> mean_, middle_, free_;  // per point: m/s
  std::vector<Vec3> bare_, behind_;      // per point, m/s: without touches; short of the response
  std::vector<double> noise_;            // per point, m/s: roundings
  std::vector<Vec3> from_, along_, to_;  // per row: directions at the start, mean, at the end
  // Where there are strings, per row: whether it is a rod or a string that may pull in this step;
  // whether it pulls; whether it is a string that was slack at the start.
  std::vector<char> taut_, pulls_, slack_;
  std::vector<double> ease_, given_, dropped_;  // 1/kg; N s: by the first stage; no more given
  std::vector<Vec3> left_, right_;              // to_, along_ of what pulls; zero for others
  std::vector<Snap> snaps_;
  bool snaps_now_ = false, slips_ = false;
  double gained_ = 0;             // m/s
  double risen_ = 0, rises_ = 0;  // J: energy above the least so far, before and after the step
  bool located_ = false;          // the step ends where something hits or snaps
  std::vector<Vec3> acceleration_, last_acceleration_;  // per point, m/s^2
  std::vector<Vec3> steady_;                            // per point, m/s^2: without waves
  std::vector<Vec3> arm_;                               // per body point, m, at the start
  std::vector<Mat3> inverse_;                           // per body at the start
  std::vector<Mat3> mobility_, bend_, stiffness_;       // per point, per point, per row
  std::vector<double> pull_, rest_, change_;            // per row: N s, m, m/s
  std::vector<double> before_pull_;                     // a relaxation
  std::vector<char> is_carried_;                        // per point: a free body has it
  std::vector<double> kept_pull_;                       // of a solution with more creep
  std::vector<double> tension_, last_tension_;          // per row, N; last_: of the step before
  double creep_ = 0;                                    // of the last solution
  double h_ = 0, last_h_ = 0, turn_ = 0;
  double slippery_ = 0;                   // s, of steps that may go with less friction
  double watched_ = 0;                    // s, for which steady_ has been told apart
  bool hits_ = false, last_hits_ = true;  // last_: there is no step before to compare with
  std::uint64_t last_pattern_ = 0;
  std::size_t solves_ = 0;
};

}  // namespace taut::direct
