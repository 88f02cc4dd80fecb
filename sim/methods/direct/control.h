// Step control: how far each step goes, and what becomes of one that went wrong.
#pragma once

#include <memory>
#include <vector>

#include "sim/method.h"
#include "sim/methods/direct/dop853.h"
#include "sim/methods/direct/net.h"

namespace taut::direct {

/// What the user asked for: an error, or a step.
struct Control {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
};

/// One component of a world on its way through time.
class Course {
 public:
  Course(const World& world, Component component, const Control& control);

  /// Reads the state from the world.
  void load(const World& world);
  /// Steps to `until` and writes the state to the world. Throws StepTooSmall.
  void advance(World& world, double until, Counters& counters);

  /// The step that the error control would have to take is lost in the rounding of the time.
  struct StepTooSmall {
    double time;
  };

 private:
  void advance_fixed(double until, Counters& counters);
  void advance_to(double until, Counters& counters);
  void accept(double time);

  Net net_;
  Control control_;
  Dop853Step careful_;
  double time_ = 0;
  double next_step_ = 0;  // s, what the error control would like; zero: unknown
  std::vector<double> q_, rate_, acceleration_;
};

}  // namespace taut::direct
