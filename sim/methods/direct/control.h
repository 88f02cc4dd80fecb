// Step control: which integrator takes a step, how far it goes, and what becomes of one that fails.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sim/method.h"
#include "sim/methods/direct/dop853.h"
#include "sim/methods/direct/net.h"
#include "sim/methods/direct/rosenbrock.h"

namespace taut::direct {

/// What the user asked for: an error, or a step.
struct Control {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
};

/// One component of a world on its way through time.
///
/// The careful integrator (DOP853) is accurate but explicit: its steps end where the waves under
/// the tension become unstable. The cheap one (ROS34PW2) has no such limit but is less accurate.
/// Each step goes to the one that gets further for its cost; the cheap one hands over to the
/// careful one where its error forces it to steps that the careful one could take as well: in
/// slack, under pushing links, in whips.
class Course {
 public:
  Course(const World& world, Component component, const Control& control);

  /// Reads the state from the world.
  void load(const World& world);
  /// Steps to `until` and writes the state to the world. Throws StepTooSmall.
  void advance(World& world, double until, Counters& counters);

  const Component& component() const { return component_; }

  /// The step that the error control would have to take is lost in the rounding of the time.
  struct StepTooSmall {
    double time;
  };

 private:
  void plan(const World& world, double time, const std::optional<Plane>& plane);
  void advance_by_tolerance(World& world, double until, double allowed, Counters& counters);
  void advance_by_step(World& world, double until, Counters& counters);
  void refresh(Counters& counters);
  double attempt(double h, Counters& counters);
  void accept(double time, Counters& counters);
  void adapt(double h, double wish, double error, Counters& counters);
  bool leave_plane(World& world);

  Component component_;
  Control control_;
  std::unique_ptr<Net> net_;
  std::unique_ptr<Dop853Step> careful_;
  std::unique_ptr<RosenbrockStep> cheap_;
  double time_ = 0, planned_at_ = 0;  // s
  std::vector<double> q_, rate_, acceleration_;
  bool fresh_ = false;      // acceleration_ and limit_ are those of the present state
  double limit_ = 0;        // s, the longest stable step of the careful integrator
  bool use_cheap_ = false;  // for the next step
  double careful_step_ = 0, cheap_step_ = 0;  // s, what their errors allow; zero: unknown
  int steps_to_probe_ = 0, probe_interval_ = 1;
};

}  // namespace taut::direct
