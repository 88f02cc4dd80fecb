// A simulation: a world, a method, and what happens at which time.
#pragma once

#include <memory>
#include <vector>

#include "sim/method.h"
#include "sim/trajectory.h"
#include "sim/world.h"

namespace taut {

/// Steps a world through time. Frame times are exact multiples, so the same world, method and times
/// give the same bits.
class Simulation {
 public:
  Simulation(World world, std::unique_ptr<Method> method);

  /// Advances to `time` (s, not before the present). Throws Diverged.
  void advance_to(double time);

  const World& world() const { return world_; }
  const Method& method() const { return *method_; }

 private:
  World world_;
  std::unique_ptr<Method> method_;
};

}  // namespace taut
