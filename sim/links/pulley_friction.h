// Coulomb's friction at pulleys: at which of them rope slides, when that changes, and what a winch
// feels of it.
#pragma once

#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"

namespace taut {

/// An integrator decides at a state what each pulley does, keeps that through a step, and measures
/// how far the next change is at its end. A step that goes beyond one is to be tried again,
/// shorter, until it ends within kNear of it. Rope that stays has a speed of exactly zero.
class PulleyFriction {
 public:
  /// Makes as much room as `mechanism` has.
  void rebuild(const Mechanism& mechanism);
  /// Whether any pulley has friction.
  bool any() const { return any_; }

  /// Lets rope stay, slide or push where it does from this state on; sets speeds within kNear of
  /// zero to zero.
  void decide(Mechanism& mechanism, TensionSystem& system, double time, std::vector<double>& state);
  /// The distance to the nearest change: m/s of a rope that slides, or of tensions as shares of
  /// their sum. Below zero: beyond it.
  double distance(Mechanism& mechanism, TensionSystem& system, double time,
                  std::vector<double>& state);
  /// The share of a step after which to look for the change that lies between these distances.
  static double share(double before, double behind);

  static constexpr double kNear = 1e-10;

 private:
  void solve(Mechanism& mechanism, TensionSystem& system, double time, std::vector<double>& state);

  bool any_ = false;
  std::vector<double> right_, tension_;
};

/// The tension (N) at the drum of the winch at a connector's first (0) or last (1) end, with the
/// world's motion as it is: the load of the drum's brake or motor, the inertia of the drum and of
/// rope still wound on it aside. Solves for all tensions of the world. Positive where the rope
/// pulls. sim/winch/README.md has the equation. Throws std::invalid_argument without such a winch.
double winch_tension(const World& world, std::size_t connector, std::size_t end);

}  // namespace taut
