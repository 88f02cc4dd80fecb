// An engine as a method of taut, so that it runs, is scored and is timed as every method is.
#pragma once

#include <exception>
#include <optional>

#include "sim/run/method.h"
#include "tests/bench/engines/points.h"
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
    if (before_.empty()) {
      require(called, world);
      try {
        build(world);
      } catch (const std::invalid_argument& error) {
        throw Diverged(kName, world.time, 0, "", 0, error.what());
      }
      before_.resize(world.connectors.size());
    }
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) {
      if (i + 1 == times.count) show(times.at(i), world);
      step(times.at(i), times.dt);
    }
    if (times.count == 0) return;
    counters_.steps += times.count;
    for (std::size_t c = 0; c < before_.size(); ++c) before_[c] = world.connectors[c].position;
    const std::vector<Body> bodies = world.bodies;
    show(until, world);
    for (std::size_t c = 0; c < before_.size(); ++c) {
      Connector& connector = world.connectors[c];
      for (std::size_t i = 0; i < before_[c].size(); ++i) {
        connector.velocity[i] = (connector.position[i] - before_[c][i]) / times.dt;
      }
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Body& body = world.bodies[b];
      body.velocity = (body.position - bodies[b].position) / times.dt;
      const Eigen::AngleAxisd turn(body.rotation * bodies[b].rotation.conjugate());
      body.spin = turn.angle() / times.dt * turn.axis();
    }
  }

 protected:
  static constexpr const char* kName = "engine";

  /// Throws std::invalid_argument with the reason where the world is more than an engine is given.
  virtual void build(const World& world) = 0;
  /// From `time` on by `dt` (s).
  virtual void step(double time, double dt) = 0;
  /// Puts the world at `time`.
  virtual void show(double time, World& world) = 0;

  const World& world() const { return *world_; }  // while it is advanced

 private:
  double step_;
  const World* world_ = nullptr;
  std::vector<std::vector<Vec3>> before_;  // m, of each connector's particles
};

/// One connector, of rods.
class RodEngine : public Engine {
 public:
  using Engine::Engine;

 protected:
  virtual void build(const Rods& rods) = 0;
  /// The upper end of the first rod (m) unless it is held, the rods' lower ends, and the load's
  /// rotation since the start.
  virtual void read(std::vector<Vec3>& ends, Quat& turn) = 0;

  Vec3 gravity(double time) const { return rods_->gravity(world(), time); }

 private:
  void build(const World& world) final {
    rods_.emplace(world);
    ends_.assign(rods_->rods().size() + 1, Vec3::Zero());
    build(*rods_);
  }
  void show(double time, World& world) final {
    Quat turn = Quat::Identity();
    read(ends_, turn);
    rods_->place(ends_, turn, time, world);
  }

  std::optional<Rods> rods_;
  std::vector<Vec3> ends_;  // m
};

/// Any connectors, joined or not, of point masses.
class NetEngine : public Engine {
 public:
  using Engine::Engine;

 protected:
  virtual void build(const Points& net) = 0;
  /// The points that move (m); `positions` has the others already.
  virtual void read(std::vector<Vec3>& positions) = 0;

 private:
  void build(const World& world) final {
    net_.emplace(world);
    for (const Point& point : net_->points()) positions_.push_back(point.position);
    build(*net_);
  }
  void show(double time, World& world) final {
    read(positions_);
    net_->place(positions_, time, world);
  }

  std::optional<Points> net_;
  std::vector<Vec3> positions_;  // m
};

/// What an engine's obstacles bring with them.
inline constexpr Features kTouched{Feature::obstacle, Feature::moving_obstacle, Feature::friction,
                                   Feature::restitution};

MethodInfo bullet_method();
MethodInfo mujoco_method();
MethodInfo ode_method();
MethodInfo bullet_net_method();
MethodInfo mujoco_net_method();
MethodInfo ode_net_method();

}  // namespace taut::engines
