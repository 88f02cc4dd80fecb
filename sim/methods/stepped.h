// The loop over steps and the integrators of all methods of fixed steps on a mechanism.
#pragma once

#include <string>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/run/method.h"

namespace taut::methods {

/// Moves a mechanism by equal steps. A method says what one step is. Everything that depends on the
/// topology is made anew in place, in room that is there from the start.
class SteppedMethod : public Method {
 public:
  void advance(World& world, double until) final;

 protected:
  /// `step` (s) is the longest step; zero: prepare() says how long.
  SteppedMethod(std::string_view name, double step) : name_(name), step_(step) {}

  /// Called when the world's topology is new: makes workspaces, and returns the longest step (s)
  /// that the method can take there; it counts only where the settings leave the step open. Then it
  /// is called again every hundred steps while winches change lengths.
  virtual double prepare(Mechanism& mechanism, const World& world) = 0;
  /// Whether velocities that stretch links must be stopped where the topology has changed on the
  /// way: those of what was pinned in motion, or let go where it was bent.
  virtual bool stops_stretch() const { return true; }
  /// Takes `state` from `time` to `time + dt`.
  virtual void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) = 0;

 private:
  void go_on(const World& world, double time, double until);

  std::string name_;
  double step_, limit_ = 0;
  bool built_ = false;
  std::uint64_t topology_ = 0;
  Mechanism mechanism_;
  Projection projection_;
  std::vector<double> state_;
};

/// The features that such methods follow as far as the mechanism does, with contact as games have
/// it.
Abilities abilities_on_mechanisms();

/// How freely a pull along each row parts its points (1/kg): at most, in whatever direction.
void row_mobility(const Mechanism& mechanism, std::vector<double>& rows);

/// Gives a workspace its size, and room to grow to `room`.
inline void resize_within(std::size_t room, std::size_t size, std::vector<double>& workspace) {
  workspace.reserve(room);
  workspace.resize(size);
}

/// Moves points and bodies of `state` by their velocities for `dt` (s): in straight lines, bodies
/// turning as they do without torque.
void drift(const Mechanism& mechanism, double dt, std::vector<double>& state);

enum class Integrator { explicit_euler, semi_implicit_euler, rk4 };
/// By its name in settings: explicit-euler, semi-implicit-euler or rk4.
Integrator integrator_named(std::string_view name);
/// The power of the step with which its error falls.
constexpr double order_of(Integrator integrator) {
  return integrator == Integrator::rk4 ? 4 : 1;
}

/// The longest stable step (s) of an oscillator x'' + 2 z w x' + w^2 x = 0, as a multiple of 1/w;
/// zero where the integrator is never stable (explicit Euler without damping).
double stability_limit(Integrator integrator, double damping_ratio);

/// Steps a mechanism under any law of tensions: a callable that fills the tension (N) of each row
/// of the mechanism at the instant of its last update.
class Stepper {
 public:
  explicit Stepper(Integrator integrator) : integrator_(integrator) {}

  /// Makes workspaces for the mechanism.
  void prepare(const Mechanism& mechanism);

  template <class Law>
  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state, Law&& law) {
    switch (integrator_) {
      case Integrator::explicit_euler:
        slope(mechanism, time, state, k1_, law);
        add(dt, k1_, state);
        break;
      case Integrator::semi_implicit_euler:
        slope(mechanism, time, state, k1_, law);
        kick_then_drift(mechanism, dt, state);
        break;
      case Integrator::rk4:
        slope(mechanism, time, state, k1_, law);
        stage(state, dt / 2, k1_);
        slope(mechanism, time + dt / 2, stage_, k2_, law);
        stage(state, dt / 2, k2_);
        slope(mechanism, time + dt / 2, stage_, k3_, law);
        stage(state, dt, k3_);
        slope(mechanism, time + dt, stage_, k4_, law);
        combine(dt, state);
        break;
    }
    normalize(mechanism, state);
  }

 private:
  template <class Law>
  void slope(Mechanism& mechanism, double time, std::vector<double>& state, std::vector<double>& k,
             Law& law) {
    mechanism.update(time, state.data());
    law(mechanism, tension_);
    mechanism.differentiate(state.data(), tension_.data(), k.data());
  }

  static void add(double dt, const std::vector<double>& k, std::vector<double>& state);
  void stage(const std::vector<double>& state, double dt, const std::vector<double>& k);
  void kick_then_drift(const Mechanism& mechanism, double dt, std::vector<double>& state);
  void combine(double dt, std::vector<double>& state);
  static void normalize(const Mechanism& mechanism, std::vector<double>& state);

  Integrator integrator_;
  std::vector<double> tension_, stage_, k1_, k2_, k3_, k4_;
};

}  // namespace taut::methods
