// Rigid links by three schemes: which one takes a step, how far it goes, and what becomes of one
// that fails.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/schemes/adams.h"
#include "sim/methods/direct/schemes/arena.h"
#include "sim/methods/direct/schemes/dop853.h"
#include "sim/methods/direct/schemes/rosenbrock.h"
#include "sim/methods/direct/system/system.h"
#include "sim/motion/plane.h"
#include "sim/run/method.h"
#include "sim/topology/components.h"

namespace taut::direct {

/// Follows one component of a world through time.
///
/// Three schemes serve: DOP853, explicit and of order 8; Adams's, explicit, with one acceleration a
/// step; ROS34PW2, implicit in the waves that the tensions carry. In this order they err more but
/// get further for their cost. Explicit steps end where the waves under the tensions become
/// unstable, Adams's with a third of the accelerations. Where the waves and not its error limit a
/// scheme, the next one is tried; where its error forces a scheme to steps that the one before
/// could take as well (in slack, under pushing links, in whips), that one goes on.
class Integrator {
 public:
  explicit Integrator(const StepOptions& options);
  Integrator(const Integrator&) = delete;

  /// Room for a component of so many links with so many ends of spans.
  void reserve(std::size_t links, std::size_t ends);
  /// Follows the component, which must stay, once it is loaded. A single span may get other indices
  /// in the world, from which it goes on.
  void follow(const Component& component) { component_ = component; }
  /// Reads the state from the world.
  void load(const World& world);
  /// Steps to `until` or beyond; writes to the world only where it has to be planned anew. Throws
  /// StepTooSmall.
  void advance(World& world, double until, Counters& counters);
  /// Writes the state at the world's time, for which it has been advanced and what is prescribed
  /// has been placed.
  void store(World& world);

  /// The tension (N) of the connector's first link in the state that store() wrote last, at `time`.
  double tension(double time, std::size_t connector, Counters& counters);

  const Component& component() const { return component_; }

  enum Scheme { dop853, adams, rosenbrock, kSchemes };
  /// The limit on a step's length: its error, the waves, the time at which a state is asked for, or
  /// the longest step allowed.
  enum class Limit { error, waves, frame, longest };
  /// A step that was taken.
  struct Step {
    Scheme scheme = dop853;
    Limit limit = Limit::error;
    double length = 0;  // s
    double waves = 0;   // rad/s, the highest frequency of waves where it began
  };
  const Step& last_step() const { return last_; }

  /// From now on tries those schemes alone of which `other` has taken steps since this was called
  /// last. One that is finer than asked for tries none before.
  void keep_to_schemes_of(const Integrator& other);

  /// The step that the error control would have to take is lost in roundings.
  struct StepTooSmall {
    double time;
  };

 private:
  static constexpr std::size_t kArrays =
      7 + Dop853Step::kResults + RosenbrockStep::kResults + AdamsStep::kArrays +
      std::max(Dop853Step::kWorkspace, RosenbrockStep::kWorkspace);
  struct Rest {  // of a scheme that has handed over, before it is tried again
    int steps = 0, interval = 0;
  };

  void plan(const World& world, double time, const std::optional<Plane>& plane);
  void begin();
  void advance_by_tolerance(World& world, double until, Counters& counters);
  void advance_by_step(World& world, double until, Counters& counters);
  bool is_before(double until);
  double first_step() const;
  bool is_lost(Scheme scheme, double h) const;
  void refresh(Counters& counters);
  StepError attempt(Scheme scheme, double h, Counters& counters);
  bool start_adams(double time, Counters& counters);
  double advance_adams(double until, Counters& counters);
  bool accept(Scheme scheme, double time, Counters& counters);
  void adapt(double h, double wish, double error, Counters& counters);
  void hand_over_to(Scheme before, Counters& counters);
  void try_next(Scheme next, double step);
  bool leave_plane(World& world);

  // How far, how wrong and to where.
  double stable_step(Scheme scheme) const;
  double asked_error() const;
  double allowed_error(Scheme scheme, double h) const;
  double share_of_allowed(Scheme scheme, double h, const StepError& error) const;
  bool lands(Scheme scheme) const;
  double length_of_step(double until, double wish) const;
  double end_of_step(double until, double h) const;
  double end_of_start(double until, double h) const;

  // Between two steps.
  void interpolate(double time, const double* first_acceleration, const double* last_acceleration);

  Component component_;
  StepOptions options_;
  PlaneFinder planes_;
  System system_;
  Dop853Step dop853_;
  AdamsStep adams_;
  RosenbrockStep rosenbrock_;
  Arena arena_;
  double time_ = 0, planned_at_ = 0;  // s
  Slice q_, rate_, acceleration_;
  double before_ = 0;  // s, where the last step began
  Step last_;
  Limit limit_ = Limit::error;  // of the step that is being tried
  Slice q_before_, rate_before_;
  Slice q_between_, rate_between_;  // at a time within that step
  bool fresh_ = false;              // acceleration_ and waves_ are those of the present state
  double waves_ = 0;                // rad/s, the highest frequency of waves
  Scheme scheme_ = dop853;          // for the next step
  double step_ = 0;                 // s, what its error allows; zero: not known yet
  double longest_ = 0;              // s, what driven ends allow
  StallWatch watch_;
  double last_turn_ = 0;  // rad, of the highest waves in DOP853's last step
  std::array<Rest, kSchemes> rests_;
  std::array<bool, kSchemes> tries_{};
  std::array<std::uint64_t, kSchemes> taken_{};  // steps
  std::array<std::uint64_t, kSchemes> seen_{};   // another's, when it was looked at last
  std::array<double, kSchemes> cost_{};          // of a step, in accelerations
  /// How many times as large a step's error would be if it was StepOptions::finer times as long.
  std::array<double, kSchemes> larger_{};
};

}  // namespace taut::direct
