// The particle system: a stiff spring with a damper for each link.
//
// Each link pulls with T = k (|d| - l) + c d|d|/dt, d the vector between its points. Every link has
// the same c/k, so that each way to stretch, of frequency w, is damped by the share c w / 2k of
// critical: most the fastest, whose share is the setting.
#include <algorithm>
#include <cmath>

#include "sim/contact/body_contacts.h"
#include "sim/contact/connector_contacts.h"
#include "sim/measure/frequency.h"
#include "sim/methods/methods.h"
#include "sim/methods/stepped.h"
#include "sim/run/error_estimate.h"

namespace taut::methods {
namespace {

constexpr double kSafety = 0.9;     // of the stability limit, when the step is left open
constexpr double kLongest = 1e-2;   // s, when nothing limits the step
constexpr double kShortest = 1e-5;  // s, when no step is stable
constexpr double kGrowth = 1;       // 1/s, of the fastest swing under explicit Euler
constexpr double kBent = 1;         // rad, where links meet: sharper bends may be unstable

/// A bound on the frequency (rad/s) of the fastest way in which rigid links of `stiffness` (N/m)
/// stretch, whatever the shape, by the mobility of their rows; 2 sqrt(k/m) for a chain of equal
/// particles.
double stretch_frequency_bound(const std::vector<double>& mobility, double stiffness) {
  // Gershgorin on J M^-1 J^T: a row's own mobility, and once more what it shares at either end.
  double most = 0;
  for (const double row : mobility) most = std::max(most, row);
  return std::sqrt(stiffness * 2 * most);
}

/// The same where more than two rows may meet in a point or a body: Gershgorin once more.
double joined_stretch_frequency_bound(const Mechanism& mechanism,
                                      const std::vector<double>& mobility, double stiffness) {
  const auto& rows = mechanism.rows();
  std::vector<double> at(mechanism.points()), on(mechanism.bodies().size()), near(rows.size(), 2);
  for (const Row& row : rows) {
    ++at[row.a];
    ++at[row.b];
  }
  const auto body = [&](const auto& end) { return mechanism.body_points()[end.body_point].body; };
  for (const auto& end : mechanism.row_ends()) ++on[body(end)];
  for (const auto& end : mechanism.row_ends())
    near[end.row] = std::max(near[end.row], on[body(end)]);
  double most = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    most = std::max(most, mobility[r] * std::max({near[r], at[rows[r].a], at[rows[r].b]}));
  }
  return std::sqrt(stiffness * most);
}

/// How freely each point moves (1/kg), those that free bodies carry as well. A clamp turns its body
/// by a lever as long as its link.
std::vector<double> point_mobility(const Mechanism& mechanism) {
  const material::MaterialForces& material = mechanism.material();
  std::vector<double> mobility = mechanism.inverse_mass(), lever(mobility.size());
  for (const auto& at : material.body_clamps()) {
    material.each_bend_at(at, [&](std::size_t bend) {
      double& longest = lever[material.bends()[bend].b];
      longest = std::max(longest, 2 * material.bent_length(bend));
    });
  }
  for (const auto& carried : mechanism.body_points()) {
    const auto& body = mechanism.bodies()[carried.body];
    const double reach = carried.local.norm() + lever[carried.point];
    mobility[carried.point] = body.inverse_mass + reach * reach * body.inverse_inertia.norm();
  }
  return mobility;
}

/// N/m, where the settings leave it open.
double own_stiffness(const World& world) {
  constexpr double kLeastStiffness = 1e4;
  constexpr double kStretched = 0.01;  // of a link at rest
  return std::max(kLeastStiffness, strongest_pull(world) / kStretched);
}

Settings with_own_stiffness(const World& world, Settings settings) {
  double& stiffness = std::get<double>(settings.find("stiffness")->second);
  if (stiffness == 0) stiffness = own_stiffness(world);
  return settings;
}

class Springs : public SteppedMethod {
 public:
  explicit Springs(const Settings& settings)
      : SteppedMethod("springs", number(settings, "step")),
        stiffness_(number(settings, "stiffness")),
        damping_(number(settings, "damping")),
        integrator_(integrator_named(text(settings, "integrator"))),
        limit_(stability_limit(integrator_, damping_)),
        stepper_(integrator_) {}

 private:
  double prepare(Mechanism& mechanism, const World& world) override {
    if (stiffness_ == 0) stiffness_ = own_stiffness(world);
    stepper_.prepare(mechanism);
    connectors_.rebuild(mechanism, world);
    bodies_.rebuild(mechanism, world);
    row_mobility(mechanism, mobility_);
    const double highest = mechanism.is_joined()
                               ? joined_stretch_frequency_bound(mechanism, mobility_, stiffness_)
                               : stretch_frequency_bound(mobility_, stiffness_);
    damper_ = highest > 0 ? 2 * damping_ * stiffness_ / highest : 0;
    const double stable = stable_step(mechanism, highest);
    if (!(stable > 0)) return kShortest;
    if (integrator_ != Integrator::explicit_euler) return stable;
    // No damper brakes a swing of frequency w, which explicit Euler makes grow at the rate w^2
    // dt/2.
    return std::min(stable, 2 * kGrowth / std::pow(highest_swing_frequency(world), 2));
  }

  /// With what stretches and bends by itself; zero where no step is stable.
  double stable_step(const Mechanism& mechanism, double highest) const {
    const double stable = std::min(kLongest, kSafety * limit_ / highest);
    if (!mechanism.material().any()) return limit_ > 0 ? stable : 0;
    const auto mode = mechanism.material().highest_mode(point_mobility(mechanism), kBent);
    const double all = std::hypot(highest, mode.frequency);
    const double share = (damping_ * highest + mode.damping / 2) / all;
    const double limit = stability_limit(integrator_, share);
    return limit > 0 ? std::min(kLongest, kSafety * limit / all) : 0;
  }

  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override {
    stepper_.step(mechanism, time, dt, state,
                  [this](const Mechanism& at, std::vector<double>& tension) {
                    for (std::size_t r = 0; r < tension.size(); ++r) {
                      tension[r] = stiffness_ * at.violation()[r] + damper_ * at.rate()[r];
                      if (!at.rows()[r].pulls) continue;
                      const bool taut = at.violation()[r] > 0 && tension[r] > 0;
                      if (!taut) tension[r] = 0;
                    }
                    ++counters_.solves;
                    counters_.cycles += at.cycles();
                  });
    if (connectors_.any()) connectors_.stop(mechanism, time + dt, dt, state);
    if (bodies_.any()) bodies_.stop(mechanism, time + dt, dt, state);
  }

  double stiffness_ = 0, damping_;  // N/m, 1
  double damper_ = 0;               // N s/m
  Integrator integrator_;
  double limit_;  // of its stable steps, as a multiple of 1/w
  Stepper stepper_;
  contact::ConnectorContacts connectors_;
  contact::BodyContacts bodies_;
  std::vector<double> mobility_;  // per row, 1/kg
};

double longest_step(const World& world, const Settings& settings) {
  return stability_limit(integrator_named(text(settings, "integrator")),
                         number(settings, "damping")) /
         highest_stretch_frequency(world, number(with_own_stiffness(world, settings), "stiffness"));
}

Companion companion_of_springs(const MethodInfo& springs, const Settings& settings) {
  if (number(settings, "step") == 0) {
    return {.none = "takes nearly the longest stable step by itself, so that no coarser one is"};
  }
  return with_step_doubled(springs, settings,
                           order_of(integrator_named(text(settings, "integrator"))));
}

}  // namespace

MethodInfo springs_method() {
  return {
      .name = "springs",
      .summary = "a particle system: a hard spring and damper per link",
      .settings = {step_setting(kStableStep, 0),
                   {.name = "stiffness",
                    .meaning = "Stiffness of each link; 0: 10000, or more under heavy loads, so "
                               "that links stretch by at most 1% at rest. Raising it reduces "
                               "stretch and needs shorter steps.",
                    .unit = "N/m",
                    .fallback = 0.0,
                    .sweep = {1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e5, 1e6, 1e7, 1e8}},
                   {.name = "damping",
                    .meaning = "Damping ratio of the fastest wave along the connector. Raising it "
                               "damps vibrations faster and dissipates more energy.",
                    .unit = "1",
                    .fallback = 0.1,
                    .maximum = 100},
                   {.name = "integrator",
                    .meaning =
                        "Integrator: rk4 is of fourth order and evaluates the forces four times a "
                        "step, the others are of first order and evaluate them once.",
                    .unit = "",
                    .fallback = std::string("semi-implicit-euler"),
                    .choices = {"explicit-euler", "semi-implicit-euler", "rk4"},
                    .sweep = {std::string("semi-implicit-euler"), std::string("rk4")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Springs>(settings);
      },
      .paper_role = PaperRole::particle_system,
      .forms = {{"explicit-euler", {{"integrator", std::string("explicit-euler")}}},
                {"rk4", {{"integrator", std::string("rk4")}}}},
      .fit = with_own_stiffness,
      .longest_step = longest_step,
      .longest_step_law = "limit of the fastest stretch w, 2 sqrt(k/m) or less",
      .abilities = abilities_on_mechanisms(),
      .companion = companion_of_springs,
      .particle_memory = 350,
  };
}

}  // namespace taut::methods
