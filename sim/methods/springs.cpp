// Each link pulls with T = k (|d| - l) + c d|d|/dt, d the vector between its points.
//
// On a chain of equal particles m the fastest wave has w = 2 sqrt(k/m) and is damped by
// z = c / sqrt(k m); the damping setting is that z, so c = z sqrt(k m) with m twice the reduced
// mass of the link's two points.
#include "sim/methods/springs.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace taut {
namespace {

constexpr double kSafety = 0.9;     // of the stability limit, when the step is left open
constexpr double kLongest = 1e-2;   // s, when nothing limits the step
constexpr double kShortest = 1e-5;  // s, when no step is stable

/// |R(q)|, the growth over a step of x' = q x / dt under RK4.
double rk4_growth(std::complex<double> q) {
  return std::abs(1.0 + q * (1.0 + q / 2.0 * (1.0 + q / 3.0 * (1.0 + q / 4.0))));
}

/// 1/kg: how easily the row's end at `point` moves, at most, in any direction.
std::vector<double> mobility(const Mechanism& mechanism) {
  std::vector<double> most = mechanism.inverse_mass();
  for (const auto& carried : mechanism.carried()) {
    const auto& body = mechanism.bodies()[carried.body];
    most[carried.point] =
        body.inverse_mass + carried.local.squaredNorm() * body.inverse_inertia.norm();
  }
  return most;
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
    const std::vector<double> mobile = mobility(mechanism);
    const auto& rows = mechanism.rows();
    damper_.resize(rows.size());
    // Gershgorin's bound on the eigenvalues of J M^-1 J^T: a row's own mobility, and once more what
    // it shares with its neighbours at each end.
    double easiest = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const double sum = mobile[rows[r].a] + mobile[rows[r].b];
      damper_[r] = sum > 0 ? damping_ * std::sqrt(stiffness_ * 2 / sum) : 0;
      easiest = std::max(easiest, 2 * sum);
    }
    if (easiest == 0) return kLongest;
    const double limit = stability_limit(integrator_, damping_) / std::sqrt(stiffness_ * easiest);
    return std::clamp(kSafety * limit, kShortest, kLongest);
  }

  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override {
    stepper_.step(mechanism, time, dt, state,
                  [this](const Mechanism& at, std::vector<double>& tension) {
                    for (std::size_t r = 0; r < tension.size(); ++r) {
                      tension[r] = stiffness_ * at.excess()[r] + damper_[r] * at.rate()[r];
                    }
                    ++counters_.solves;
                  });
  }

  double stiffness_, damping_;
  Integrator integrator_;
  Stepper stepper_;
  std::vector<double> damper_;  // N s/m
};

}  // namespace

double stability_limit(Integrator integrator, double damping_ratio) {
  const double z = damping_ratio;
  if (integrator == Integrator::semi_implicit_euler) return 2 * (std::sqrt(1 + z * z) - z);
  if (integrator == Integrator::explicit_euler) {
    return z <= 1 ? 2 * z : 2 * (z - std::sqrt(z * z - 1));
  }
  // The largest h = w dt at which the oscillator's faster root s/w = -z - sqrt(z^2 - 1) does not
  // grow.
  const std::complex<double> root = -z - std::sqrt(std::complex<double>(z * z - 1));
  double stable = 0, unstable = 4;
  for (int halving = 0; halving < 50; ++halving) {
    const double h = (stable + unstable) / 2;
    (rk4_growth(h * root) <= 1 ? stable : unstable) = h;
  }
  return stable;
}

MethodInfo springs_method() {
  return {
      .name = "springs",
      .summary = "A particle system: a hard spring and damper per link.",
      .settings = {{.name = "step",
                    .meaning = "Time step; zero takes nine tenths of the stability limit.",
                    .unit = "s",
                    .fallback = 0.0,
                    .maximum = 1},
                   {.name = "stiffness",
                    .meaning =
                        "Stiffness of each link; more stretches less and needs shorter steps.",
                    .unit = "N/m",
                    .fallback = 1e4,
                    .above = true},
                   {.name = "damping",
                    .meaning =
                        "Damping of the fastest wave along the connector, as a share of critical.",
                    .unit = "1",
                    .fallback = 0.1,
                    .maximum = 100},
                   {.name = "integrator",
                    .meaning = "How a step is taken.",
                    .unit = "",
                    .fallback = std::string("semi-implicit-euler"),
                    .choices = {"explicit-euler", "semi-implicit-euler", "rk4"}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Springs>(settings);
      }};
}

}  // namespace taut
