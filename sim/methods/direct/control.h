// Step control: which integrator takes a step, how far it goes, and what becomes of one that fails.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sim/method.h"
#include "sim/methods/direct/adams.h"
#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/backward.h"
#include "sim/methods/direct/components.h"
#include "sim/methods/direct/dop853.h"
#include "sim/methods/direct/leap.h"
#include "sim/methods/direct/net.h"
#include "sim/methods/direct/planar_chain.h"
#include "sim/methods/direct/plane.h"
#include "sim/methods/direct/rosenbrock.h"

namespace taut::direct {

/// What the user asked for: an error, or a step.
struct Control {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
};

/// One component of a world on its way through time.
///
/// Its integrators form a ladder, from the careful DOP853 over Adams's to the implicit ROS34PW2.
/// Going up they are less accurate but get further for their cost: explicit steps end where the
/// waves under the tension become unstable, Adams's with a third of the accelerations. Where a rung
/// is held up by those waves and not by its error, the next one is tried; where its error forces it
/// to steps that the rung below could take as well (in slack, under pushing links, in whips), it
/// hands over to that. Where errors of per cents will do, waves do not count: the implicit one
/// takes all steps but those from a start that they do not stiffen yet. Where still larger ones
/// will do, BDF2 takes all steps for as long as they are long or, from a start that waves do not
/// stiffen, leaps; these are worth it for errors of one per cent, too, where links push and none
/// pulls, or where no wave comes near to stiffening it.
class Course {
 public:
  explicit Course(const Control& control) : control_(control) {}
  Course(const Course&) = delete;

  /// Room for a component of so many links with so many ends of spans, in a world of so many
  /// bodies.
  void reserve(std::size_t links, std::size_t ends, std::size_t bodies);
  /// Follows the component, which must stay, once it is loaded.
  void follow(const Component& component) { component_ = component; }
  /// Reads the state from the world.
  void load(const World& world);
  /// Steps to `until` or beyond; writes to the world only where it has to be planned anew. Throws
  /// StepTooSmall.
  void advance(World& world, double until, Counters& counters);
  /// Writes the state at the world's time, for which it has been advanced and what is prescribed
  /// has been placed.
  void store(World& world);

  const Component& component() const { return component_; }

  /// The step that the error control would have to take is lost in the rounding of the time.
  struct StepTooSmall {
    double time;
  };

 private:
  enum Rung { careful, adams, implicit, kRungs };
  static constexpr std::size_t kArrays = 9 + Dop853Step::kArrays + AdamsStep::kArrays +
                                         RosenbrockStep::kArrays + BackwardStep::kArrays +
                                         LeapStep::kArrays;
  /// A fixed step whose error estimate exceeds this share of the length of all links is done again.
  static constexpr double kCoarsest = 0.01;
  /// Adams keeps its spacing down to this share of the step that is possible.
  static constexpr double kLeastSpacing = 0.75;
  struct Rest {  // of a rung that the one below has to try again
    int steps = 0, interval = 0;
  };

  void plan(const World& world, double time, const std::optional<Plane>& plane);
  void advance_by_tolerance(World& world, double until, Counters& counters);
  void advance_loosely(World& world, double until, Counters& counters);
  double attempt_loosely(double h, Counters& counters);
  void advance_by_step(World& world, double until, Counters& counters);
  void begin();
  double first_step(double turn) const;
  void advance_audited(World& world, double until, Counters& counters);
  bool balances();
  void note_shown(double time);
  void go_on_finer();
  void interpolate(double time, const double* first_acceleration, const double* last_acceleration);
  void refresh(Counters& counters);
  double stable_step(Rung rung) const;
  double allowed_error(Rung rung, double h) const;
  bool lands(Rung rung) const;
  double length_of_step(double until, double wish) const;
  double end_of_step(double until, double h) const;
  double end_of_start(double until, double h) const;
  double attempt(Rung rung, double h, Counters& counters);
  void start_adams(double time, Counters& counters);
  double march(double until, Counters& counters);
  void accept(Rung rung, double time, Counters& counters);
  void adapt(double h, double wish, double error, Counters& counters);
  void hand_over_to(Rung below, Counters& counters);
  void climb(Rung to, double step);
  bool leave_plane(World& world);

  Component component_;
  Control control_;
  PlaneFinder planes_;
  PlanarChain chain_;
  Net net_;
  Motion* motion_ = nullptr;  // one of the two
  Dop853Step careful_;
  AdamsStep adams_;
  RosenbrockStep implicit_;
  BackwardStep backward_;
  LeapStep leap_;
  Arena arena_;
  double time_ = 0, planned_at_ = 0;  // s
  Slice q_, rate_, acceleration_;
  double before_ = 0;  // s, where the last step began
  Slice q_before_, rate_before_;
  Slice q_between_, rate_between_;  // at a time within that step
  bool closed_ = false;             // nothing does work on it but gravity
  bool rough_ = false;              // an error of per cents of the length will do
  bool loose_ = false;              // so will a larger one, and BDF2 or leaps are worth it
  bool only_leaps_ = false;         // leaps are worth it, and nothing else
  bool soft_ = false;               // no wave stiffened its start
  bool leaps_ = false;              // leaps for now
  bool looks_back_ = false;         // there is a step to look back to
  double tolerance_ = 0;            // m, the one asked for or, since an audit failed, a finer one
  bool fixed_ = false;              // steps are the fixed ones that were asked for
  double known_energy_ = 0;         // J, where it was loaded or, since an audit failed, was shown
  Slice q_shown_, rate_shown_;      // the last state that the world has seen
  double shown_at_ = 0;             // s
  bool fresh_ = false;              // acceleration_ and fastest_ are those of the present state
  double fastest_ = 0;              // rad/s, of the waves
  Rung rung_ = careful;             // for the next step
  double step_ = 0;                 // s, what its error allows; zero: not known yet
  double longest_ = 0;              // s, what driven ends allow
  double reach_ = 0;                // rad, of the fastest waves, that careful steps may go
  std::array<Rest, kRungs> rests_;
  std::array<double, kRungs> cost_{};  // of a step, in accelerations
};

}  // namespace taut::direct
