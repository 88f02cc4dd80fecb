// A world as a Simbody system. Simbody's headers are C++17 at most: its one source is compiled so.
#pragma once

#include <memory>
#include <string>

#include "sim/world/world.h"

namespace taut::reference {

/// Links are massless lines with a particle at their far end, on two-axis joints that know every
/// direction (a quaternion and two speeds), so that no coordinates are singular; rigid bodies hang
/// on ball joints. The tree grows from what is held; a link that closes a loop is a rod constraint.
///
/// Throws std::runtime_error with Simbody's message, when it is made and when it runs.
class SimbodyModel {
 public:
  /// Starts from the state of `world`. `integrator` is merson, runge-kutta-3 or verlet.
  SimbodyModel(const World& world, const std::string& integrator, double accuracy);
  ~SimbodyModel();

  /// Goes on to `until` (s) and writes the state to `world`, whose own state is not read.
  void advance(World& world, double until);

  double time() const;  // s, that it has reached
  int steps() const;
  int attempts() const;      // steps and those undone
  int realizations() const;  // of the equations of motion

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace taut::reference
