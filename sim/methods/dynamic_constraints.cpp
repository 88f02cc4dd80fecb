// Dynamic constraints (Barzel and Barr 1988): forces that keep every link at its length.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/links/tension.h"
#include "sim/measure/frequency.h"
#include "sim/methods/methods.h"
#include "sim/methods/stepped.h"
#include "sim/motion/stop.h"
#include "sim/run/error_estimate.h"

namespace taut::methods {
namespace {

constexpr std::string_view kDynamicConstraints = "dynamic-constraints";
// When the step is left open:
constexpr double kShareOfStable = 0.5;  // of the stability limit
constexpr double kLongestStep = 1e-3;   // s
constexpr double kMostParts = 1e4;      // that a step is split into
constexpr double kStepsToReturn = 10;   // time constant in steps, where the settings leave it open

class DynamicConstraints final : public SteppedMethod {
 public:
  /// Steps that the settings leave open are `longer` times as long as by default.
  explicit DynamicConstraints(const Settings& settings, double longer = 1)
      : SteppedMethod(kDynamicConstraints, number(settings, "step")),
        adaptive_(number(settings, "step") == 0),
        safety_(kShareOfStable * longer),
        longest_(kLongestStep * longer),
        time_constant_(number(settings, "time_constant")),
        dense_(text(settings, "solver") == "dense"),
        integrator_(integrator_named(text(settings, "integrator"))),
        stability_limit_(stability_limit(integrator_, 0)),
        stepper_(integrator_) {}

 private:
  double prepare(Mechanism& mechanism, const World& world) override {
    stepper_.prepare(mechanism);
    system_.rebuild(mechanism);
    resize_within(mechanism.row_room(), mechanism.rows().size(), right_);
    row_mobility(mechanism, mobility_);
    start_.reserve(mechanism.state_room());
    highest_squared_ = 0;
    const double longest = safety_ * stability_limit_;  // times 1/w
    if (longest_ * std::sqrt(4 * heaviest_link(world)) <= longest) return longest_;
    return std::min(longest_, longest / highest_swing_frequency(world));
  }

  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override {
    if (!adaptive_) return single_step(mechanism, time, dt, state);
    start_ = state;
    for (double parts = parts_of(dt);; parts = parts_of(dt)) {
      const double part = dt / parts;
      highest_squared_ = 0;
      for (double i = 0; i < parts; ++i) {
        check_stop();
        single_step(mechanism, time + i * part, part, state);
      }
      counters_.steps += static_cast<std::uint64_t>(parts) - 1;
      // A jerk shows in the tensions only when it is there: then once more, finer.
      if (parts == kMostParts || parts_of(dt) <= 2 * parts) return;
      ++counters_.rejected;
      state = start_;
    }
  }

  void single_step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) {
    const double tau = time_constant_ > 0 ? time_constant_ : kStepsToReturn * dt;
    stepper_.step(
        mechanism, time, dt, state, [&](const Mechanism& at, std::vector<double>& tension) {
          system_.assemble(at);
          for (std::size_t r = 0; r < right_.size(); ++r) {
            right_[r] =
                at.free_acceleration(r) + (2 * at.rate()[r] + at.violation()[r] / tau) / tau;
          }
          ++counters_.solves;
          counters_.cycles += at.cycles();
          if (dense_) {
            system_.solve_dense(right_, tension);
            counters_.cycles += system_.dense_cycles();
          } else {
            counters_.cycles += system_.cycles();
            if (!system_.solve(right_, tension)) {
              ++counters_.handed_over;
              counters_.cycles += system_.dense_cycles();
            }
          }
          if (adaptive_) {
            highest_squared_ = std::max(highest_squared_, swings_squared(at, tension));
          }
        });
  }

  /// A bound on the frequency (rad/s) of the swings that tensions drive, squared: in each row of
  /// rest length l, 2 T/l times the mobility of its points, which is 4 T/(m l) between equal
  /// particles.
  double swings_squared(const Mechanism& mechanism, const std::vector<double>& tension) const {
    double squared = 0;
    for (std::size_t r = 0; r < tension.size(); ++r) {
      const double rest = mechanism.rows()[r].rest;
      if (rest > 0) squared = std::max(squared, 2 * tension[r] / rest * mobility_[r]);
    }
    return squared;
  }
  /// Into how many parts a step must go to be stable under the tensions of the step before.
  double parts_of(double dt) const {
    const double parts = dt * std::sqrt(highest_squared_) / (safety_ * stability_limit_);
    return std::clamp(std::ceil(parts), 1.0, kMostParts);
  }

  bool adaptive_;         // the settings leave the step open
  double safety_;         // of the stability limit
  double longest_;        // s
  double time_constant_;  // s
  bool dense_;
  Integrator integrator_;
  double stability_limit_;  // 1/w
  Stepper stepper_;
  TensionSystem system_;
  std::vector<double> right_;     // m/s^2
  std::vector<double> mobility_;  // per row, 1/kg
  std::vector<double> start_;     // the state before the step
  double highest_squared_ = 0;    // (rad/s)^2, in the step before
};

/// Sideways a connector under tension moves freely, and its lengths return critically damped.
double stable_step(const World& world, const Settings& settings) {
  const Integrator integrator = integrator_named(text(settings, "integrator"));
  const double tau = number(settings, "time_constant");
  const double returning = tau > 0 ? stability_limit(integrator, 1) * tau : 1e300;
  return std::min(returning, stability_limit(integrator, 0) / highest_swing_frequency(world));
}

/// Twice as long, steps that are left open would be as long as stability allows.
Companion companion_of_constraints(const MethodInfo& constraints, const Settings& settings) {
  const double order = order_of(integrator_named(text(settings, "integrator")));
  if (number(settings, "step") > 0) return with_step_doubled(constraints, settings, order);
  return {.method = std::make_unique<DynamicConstraints>(settings, std::numbers::sqrt2),
          .order = order};
}

}  // namespace

MethodInfo dynamic_constraints_method() {
  return {
      .name = kDynamicConstraints,
      .summary = "forces from the system of all links, returning critically damped",
      .settings = {step_setting(kStableStep, 10),
                   {.name = "time_constant",
                    .meaning =
                        "Time constant of the decay of length errors, at least 1.3 steps; 0: ten "
                        "steps. Raising it allows longer steps and larger length errors.",
                    .unit = "s",
                    .fallback = 0.0,
                    .maximum = 100},
                   {.name = "solver",
                    .meaning = "Solver for the tensions: tridiagonal costs O(n) for n links, dense "
                               "O(n^3), as the paper timed it.",
                    .unit = "",
                    .fallback = std::string("tridiagonal"),
                    .choices = {"tridiagonal", "dense"}},
                   {.name = "integrator",
                    .meaning =
                        "Integrator: rk4 is of fourth order and solves for the tensions four times "
                        "a step, semi-implicit-euler is of first order and solves once.",
                    .unit = "",
                    .fallback = std::string("rk4"),
                    .choices = {"semi-implicit-euler", "rk4"},
                    .sweep = {std::string("semi-implicit-euler"), std::string("rk4")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<DynamicConstraints>(settings);
      },
      .paper_role = PaperRole::dynamic_constraints,
      .forms = {{"dense", {{"solver", std::string("dense")}}}},
      .longest_step = stable_step,
      .longest_step_law = "2/w (Euler) or 2.83/w (RK4), w the fastest swing",
      .abilities = {kPlainFeatures},
      .companion = companion_of_constraints,
      .particle_memory = 700,
      .eliminates = true,
  };
}

}  // namespace taut::methods
