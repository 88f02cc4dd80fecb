// One component of a world on its way through time.
#pragma once

#include <optional>

#include "sim/method.h"
#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/bdf.h"
#include "sim/methods/direct/components.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/dop853.h"
#include "sim/methods/direct/plane_finder.h"
#include "sim/methods/direct/system.h"
#include "sim/methods/direct/verlet.h"

namespace taut::direct {

/// Takes steps of the scheme that the controller asks for, past the times at which states are shown
/// where the scheme is one of small steps, else to just there. What has been shown stays.
class Integrator {
 public:
  explicit Integrator(const Options& options) : controller_(options) {}
  Integrator(const Integrator&) = delete;

  /// Room for a component of so many links with so many ends of spans, in a world of so many
  /// bodies.
  void reserve(std::size_t links, std::size_t ends, std::size_t bodies);
  /// Follows the component, which must stay, once it is loaded.
  void follow(const Component& component) { component_ = component; }
  /// Reads the state from the world.
  void load(const World& world);
  /// Steps to `until` or beyond. Throws StepTooSmall.
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
  static constexpr std::size_t kArrays =
      11 + Dop853Step::kArrays + VerletStep::kArrays + BdfStep::kArrays;

  void plan(const World& world, const std::optional<Plane>& plane);
  void refresh(Counters& counters);
  bool leave_plane(World& world);
  Outcome attempt(const Step& step, Counters& counters);
  void accept(const Step& step, Counters& counters);

  Component component_;
  Controller controller_;
  PlaneFinder planes_;
  System system_;
  Dop853Step dop853_;
  VerletStep verlet_;
  BdfStep bdf_;
  Arena arena_;
  double time_ = 0, before_ = 0;  // s, of the state and of the one before
  double planned_at_ = 0;         // s
  Slice q_, v_, a_, q_before_, v_before_;
  Slice first_, inner_;          // accelerations at the start of dop853's last step and in it
  double inner_at_ = 0;          // s
  Slice q_between_, v_between_;  // at a time between the two
  bool fresh_ = false;           // a_ and the tensions are those of the present state
  bool started_ = false;         // the scheme of small steps knows a state before
};

}  // namespace taut::direct
