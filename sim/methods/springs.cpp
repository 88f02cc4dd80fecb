// Each link pulls with T = k (|d| - l) + c d|d|/dt, d the vector between its points. Every link has
// the same c/k, so that each way to stretch, of frequency w, is damped by the share c w / 2k of
// critical: most the fastest, whose share is the setting.
#include "sim/methods/springs.h"

#include <algorithm>
#include <cmath>

#include "sim/frequency.h"
#include "sim/methods/stepped.h"

namespace taut {
namespace {

constexpr double kSafety = 0.9;     // of the stability limit, when the step is left open
constexpr double kLongest = 1e-2;   // s, when nothing limits the step
constexpr double kShortest = 1e-5;  // s, when no step is stable

/// A bound on the frequency (rad/s) of the fastest way in which links of `stiffness` (N/m) stretch,
/// whatever the shape; 2 sqrt(k/m) for a chain of equal particles.
double fastest_wave(const Mechanism& mechanism, double stiffness) {
  std::vector<double> mobile = mechanism.inverse_mass();  // 1/kg, at most, in any direction
  for (const auto& carried : mechanism.carried()) {
    const auto& body = mechanism.bodies()[carried.body];
    mobile[carried.point] =
        body.inverse_mass + carried.local.squaredNorm() * body.inverse_inertia.norm();
  }
  // Gershgorin on J M^-1 J^T: a row's own mobility, and once more what it shares at either end.
  double most = 0;
  for (const Row& row : mechanism.rows()) most = std::max(most, mobile[row.a] + mobile[row.b]);
  return std::sqrt(stiffness * 2 * most);
}

class Springs : public SteppedMethod {
 public:
  explicit Springs(const Settings& settings)
      : SteppedMethod("springs", number(settings, "step")),
        stiffness_(number(settings, "stiffness")),
        damping_(number(settings, "damping")),
        integrator_(integrator_named(text(settings, "integrator"))) {}

 private:
  double prepare(Mechanism& mechanism) override {
    stepper_ = Stepper(mechanism, integrator_);
    const double fastest = fastest_wave(mechanism, stiffness_);
    damper_ = fastest > 0 ? 2 * damping_ * stiffness_ / fastest : 0;
    const double limit = stability_limit(integrator_, damping_);
    if (!(limit > 0)) return kShortest;
    return std::min(kLongest, kSafety * limit / fastest);
  }

  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override {
    stepper_.step(mechanism, time, dt, state,
                  [this](const Mechanism& at, std::vector<double>& tension) {
                    for (std::size_t r = 0; r < tension.size(); ++r) {
                      tension[r] = stiffness_ * at.excess()[r] + damper_ * at.rate()[r];
                    }
                    ++counters_.solves;
                  });
  }

  double stiffness_, damping_;  // N/m, 1
  double damper_ = 0;           // N s/m
  Integrator integrator_;
  Stepper stepper_;
};

double longest_step(const World& world, const Settings& settings) {
  return stability_limit(integrator_named(text(settings, "integrator")),
                         number(settings, "damping")) /
         fastest_stretch(world, number(settings, "stiffness"));
}

}  // namespace

MethodInfo springs_method() {
  return {
      .name = "springs",
      .summary = "a particle system: a hard spring and damper per link",
      .settings = {{.name = "step",
                    .meaning = "The time step; zero takes nine tenths of the stability limit.",
                    .unit = "s",
                    .fallback = 0.0,
                    .maximum = 1},
                   {.name = "stiffness",
                    .meaning = "Of each link; more stretches less and needs shorter steps.",
                    .unit = "N/m",
                    .fallback = 1e4,
                    .above = true,
                    .sweep = {1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5, 1e6, 1e7}},
                   {.name = "damping",
                    .meaning = "Of the fastest wave along the connector, as a share of critical.",
                    .unit = "1",
                    .fallback = 0.1,
                    .maximum = 100},
                   {.name = "integrator",
                    .meaning = "How a step is taken; rk4 sums the forces four times.",
                    .unit = "",
                    .fallback = std::string("semi-implicit-euler"),
                    .choices = {"explicit-euler", "semi-implicit-euler", "rk4"},
                    .sweep = {std::string("semi-implicit-euler"), std::string("rk4")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Springs>(settings);
      },
      .forms = {{"explicit-euler", {{"integrator", std::string("explicit-euler")}}},
                {"rk4", {{"integrator", std::string("rk4")}}}},
      .longest_step = longest_step,
      .longest_step_law = "(2/w)(sqrt(1+z^2) - z), w the fastest stretch",
  };
}

}  // namespace taut
