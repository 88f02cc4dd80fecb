// Stretch, bending and air as games do them: compliant constraints, projected one after another.
#pragma once

#include <vector>

#include "sim/links/mechanism.h"

namespace taut::methods {

/// Macklin, Mueller and Chentanez, XPBD, 2016: a constraint C of energy k C^2 / 2 has a multiplier
/// (kg m) of its own, and damping c acts on what C has changed by since the step began.
class XpbdMaterial {
 public:
  void rebuild(const Mechanism& mechanism);
  bool any() const { return any_; }

  /// The air's push in a step of `dt` (s), before particles fly.
  void blow(const Mechanism& mechanism, double dt, std::vector<double>& state);
  /// Forgets the multipliers, as a step begins from `started`.
  void begin(const std::vector<double>& started);
  /// Goes through all elements once.
  void pass(const Mechanism& mechanism, double dt, double* state);

 private:
  struct Change {  // of a constraint with a point
    std::uint32_t point = 0;
    Vec3 gradient = Vec3::Zero();
  };
  template <std::size_t N>
  void project(const Mechanism& mechanism, double dt, double stiffness, double damping,
               double value, const Change (&changes)[N], double& multiplier, double* state);

  void project_twist(const Mechanism& mechanism, double dt, const material::TwistElement& rod,
                     double& multiplier, double* state);

  /// The body's point at a point that a free body carries; null: none does.
  const Mechanism::BodyPoint* carried(const Mechanism& mechanism, std::uint32_t point) const {
    const std::uint32_t at = carried_.empty() ? kNone : carried_[point];
    return at == kNone ? nullptr : &mechanism.body_points()[at];
  }

  static constexpr std::uint32_t kNone = 0xffffffff;
  bool any_ = false;
  std::vector<std::uint32_t> carried_;  // of each point, in body_points(); empty: no body
  std::vector<double> multiplier_;      // of stretches, then of bends
  std::vector<double> started_;
  std::vector<Vec3> force_;
};

}  // namespace taut::methods
