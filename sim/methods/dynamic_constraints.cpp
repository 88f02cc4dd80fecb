#include "sim/methods/dynamic_constraints.h"

#include <algorithm>

#include "sim/frequency.h"
#include "sim/methods/stepped.h"
#include "sim/tension.h"

namespace taut {
namespace {

constexpr std::string_view kName = "dynamic-constraints";
constexpr double kStepsToReturn = 10;  // time constant in steps, where the settings leave it open

class DynamicConstraints final : public SteppedMethod {
 public:
  explicit DynamicConstraints(const Settings& settings)
      : SteppedMethod(kName, number(settings, "step")),
        time_constant_(number(settings, "time_constant")),
        dense_(text(settings, "solver") == "dense"),
        integrator_(integrator_named(text(settings, "integrator"))) {}

 private:
  double prepare(Mechanism& mechanism) override {
    stepper_ = Stepper(mechanism, integrator_);
    system_.emplace(mechanism);
    right_.resize(mechanism.rows().size());
    return 0;
  }

  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override {
    const double tau = time_constant_ > 0 ? time_constant_ : kStepsToReturn * dt;
    stepper_.step(
        mechanism, time, dt, state, [&](const Mechanism& at, std::vector<double>& tension) {
          system_->assemble(at);
          for (std::size_t r = 0; r < right_.size(); ++r) {
            right_[r] =
                at.loose_excess_acceleration(r) + (2 * at.rate()[r] + at.excess()[r] / tau) / tau;
          }
          ++counters_.solves;
          if (dense_) {
            system_->solve_dense(right_, tension);
          } else if (system_->solve(right_, tension)) {
            ++counters_.handed_over;
          }
        });
  }

  double time_constant_;  // s
  bool dense_;
  Integrator integrator_;
  Stepper stepper_;
  std::optional<TensionSystem> system_;
  std::vector<double> right_;  // m/s^2
};

/// Sideways a connector under tension moves freely, and its lengths return critically damped.
double longest_step(const World& world, const Settings& settings) {
  const Integrator integrator = integrator_named(text(settings, "integrator"));
  const double tau = number(settings, "time_constant");
  const double returning = tau > 0 ? stability_limit(integrator, 1) * tau : 1e300;
  return std::min(returning, stability_limit(integrator, 0) / fastest_swing(world));
}

}  // namespace

MethodInfo dynamic_constraints_method() {
  return {
      .name = kName,
      .summary = "forces from the system of all links, returning critically damped",
      .settings = {{.name = "step",
                    .meaning = "The time step; smaller is more accurate and costs in proportion.",
                    .unit = "s",
                    .fallback = 0.001,
                    .maximum = 1,
                    .above = true,
                    .sweep = halvings(1.0 / 60, 10)},
                   {.name = "time_constant",
                    .meaning =
                        "In which length errors return by e, 1.3 steps or more; zero: ten steps.",
                    .unit = "s",
                    .fallback = 0.0,
                    .maximum = 100},
                   {.name = "solver",
                    .meaning =
                        "Elimination along the connector, or decomposition of the whole matrix.",
                    .unit = "",
                    .fallback = std::string("tridiagonal"),
                    .choices = {"tridiagonal", "dense"}},
                   {.name = "integrator",
                    .meaning = "How a step is taken; rk4 solves four times.",
                    .unit = "",
                    .fallback = std::string("rk4"),
                    .choices = {"semi-implicit-euler", "rk4"},
                    .sweep = {std::string("semi-implicit-euler"), std::string("rk4")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<DynamicConstraints>(settings);
      },
      .forms = {{"dense", {{"solver", std::string("dense")}}}},
      .longest_step = longest_step,
      .longest_step_law = "2/w (Euler), 2.83/w (RK4), w the fastest swing",
  };
}

}  // namespace taut
