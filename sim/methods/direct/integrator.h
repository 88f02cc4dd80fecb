// One component of a world on its way through time.
#pragma once

#include <optional>

#include "sim/method.h"
#include "sim/methods/direct/arena.h"
#include "sim/methods/direct/components.h"
#include "sim/methods/direct/dop853.h"
#include "sim/methods/direct/plane_finder.h"
#include "sim/methods/direct/system.h"

namespace taut::direct {

/// What the user asked for: an error, or a step.
struct Options {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
};

class Integrator {
 public:
  explicit Integrator(const Options& options) : options_(options) {}
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
  static constexpr std::size_t kArrays = 6 + Dop853Step::kArrays;
  void plan(const World& world, const std::optional<Plane>& plane);
  void refresh(Counters& counters);
  bool leave_plane(World& world);

  Component component_;
  Options options_;
  PlaneFinder planes_;
  System system_;
  Dop853Step dop853_;
  Arena arena_;
  double time_ = 0, planned_at_ = 0;
  Slice q_, v_, a_;
  bool fresh_ = false;
  double frequency_ = 0;
  double step_ = 0;
};

}  // namespace taut::direct
