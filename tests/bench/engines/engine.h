// An engine as a method of taut, so that it runs, is scored and is timed as every method is.
#pragma once

#include <exception>
#include <optional>

#include "sim/run/method.h"
#include "tests/bench/engines/rods.h"

namespace taut::engines {

/// Advances what was built from the world that it first saw; positions come back, velocities do
/// not.
class Engine : public Method {
 public:
  explicit Engine(double step) : step_(step) {}

  void advance(World& world, double until) final {
    world_ = &world;
    if (!rods_) {
      try {
        rods_.emplace(world);
      } catch (const std::invalid_argument& error) {
        throw Diverged("engine", world.time, 0, "", 0, error.what());
      }
      ends_.resize(rods_->rods().size());
      build(*rods_);
    }
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) step(times.at(i), times.dt);
    counters_.steps += times.count;
    Quat turn = Quat::Identity();
    read(ends_, turn);
    rods_->place(ends_, turn, until, world);
  }

 protected:
  virtual void build(const Rods& rods) = 0;
  /// From `time` on by `dt` (s).
  virtual void step(double time, double dt) = 0;
  /// The rods' lower ends (m), and the load's rotation since the start.
  virtual void read(std::vector<Vec3>& ends, Quat& turn) = 0;

  Vec3 gravity(double time) const { return rods_->gravity(*world_, time); }

 private:
  double step_;
  const World* world_ = nullptr;  // while it is advanced
  std::optional<Rods> rods_;
  std::vector<Vec3> ends_;
};

MethodInfo bullet_method();
MethodInfo mujoco_method();
MethodInfo ode_method();

}  // namespace taut::engines
