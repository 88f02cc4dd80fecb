#include "sim/methods/dynamic_constraints.h"

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

}  // namespace

MethodInfo dynamic_constraints_method() {
  return {
      kName,
      "forces from the system of all links, returning critically damped (Barzel and Barr)",
      {{"step", "The time step; smaller is more accurate and costs in proportion.", "s", 0.001, 0,
        1, true},
       {"time_constant",
        "Time in which a length error decays by e, at least 1.3 steps; smaller is stiffer, and "
        "zero takes ten steps.",
        "s", 0.0, 0, 100},
       {.name = "solver",
        .meaning = "tridiagonal eliminates along the connector; dense decomposes the whole matrix.",
        .unit = "",
        .fallback = std::string("tridiagonal"),
        .choices = {"tridiagonal", "dense"}},
       {.name = "integrator",
        .meaning = "How a step is taken.",
        .unit = "",
        .fallback = std::string("rk4"),
        .choices = {"semi-implicit-euler", "rk4"}}},
      [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<DynamicConstraints>(settings);
      }};
}

}  // namespace taut
