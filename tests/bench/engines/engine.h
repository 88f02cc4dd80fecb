// An engine as a method of taut, so that it runs, is scored and is timed as every method is.
#pragma once

#include <exception>
#include <optional>

#include "sim/run/method.h"
#include "tests/bench/engines/rods.h"

namespace taut::engines {

/// Advances what was built from the world that it first saw. Velocities are those of the last
/// step's way: engines have them at the half of it or, as Euler's semi-implicit method has, at its
/// end.
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
      ends_.assign(rods_->rods().size() + 1, Vec3::Zero());
      build(*rods_);
    }
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) {
      if (i + 1 == times.count) show(times.at(i), world);
      step(times.at(i), times.dt);
    }
    if (times.count == 0) return;
    counters_.steps += times.count;
    before_ = world.connectors[0].position;
    const std::vector<Body> bodies = world.bodies;
    show(until, world);
    Connector& connector = world.connectors[0];
    for (std::size_t i = 0; i < before_.size(); ++i) {
      connector.velocity[i] = (connector.position[i] - before_[i]) / times.dt;
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Body& body = world.bodies[b];
      body.velocity = (body.position - bodies[b].position) / times.dt;
      const Eigen::AngleAxisd turn(body.rotation * bodies[b].rotation.conjugate());
      body.spin = turn.angle() / times.dt * turn.axis();
    }
  }

 protected:
  virtual void build(const Rods& rods) = 0;
  /// From `time` on by `dt` (s).
  virtual void step(double time, double dt) = 0;
  /// The upper end of the first rod (m) unless it is held, the rods' lower ends, and the load's
  /// rotation since the start.
  virtual void read(std::vector<Vec3>& ends, Quat& turn) = 0;

  Vec3 gravity(double time) const { return rods_->gravity(*world_, time); }

 private:
  void show(double time, World& world) {
    Quat turn = Quat::Identity();
    read(ends_, turn);
    rods_->place(ends_, turn, time, world);
  }

  double step_;
  const World* world_ = nullptr;  // while it is advanced
  std::optional<Rods> rods_;
  std::vector<Vec3> ends_, before_;  // m
};

MethodInfo bullet_method();
MethodInfo mujoco_method();
MethodInfo ode_method();

}  // namespace taut::engines
