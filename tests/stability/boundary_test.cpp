// Where explicit steps become unstable, on a hanging chain that is hardly moved: a tenth below the
// theory's limit the motion stays small, a tenth above it grows without end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../physics/worlds.h"
#include "sim/measure/measure.h"
#include "sim/methods/stepped.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::boundary_test {
namespace {

constexpr std::size_t kBeads = 20;
constexpr double kKick = 1e-6;  // m
constexpr double kGrown = 1e3;  // times the kick
constexpr std::uint64_t kSteps = 1000;

/// A hanging chain whose links are stretched by what hangs below, each a spring of `stiffness`
/// (N/m), and whose beads are moved by turns to one side and the other, up and down.
World hanging(double stiffness) {
  World world = worlds::chain(kBeads + 1, 1, -Vec3::UnitY());
  Connector& chain = world.connectors[0];
  double sag = 0;
  for (std::size_t i = 1; i <= kBeads; ++i) {
    const double below = static_cast<double>(kBeads + 1 - i) * chain.particle_mass[1];
    sag += below * worlds::kGravity / stiffness;
    const double kick = i % 2 == 0 ? kKick : -kKick;
    chain.position[i] += Vec3(kick, kick / 10 - sag, 0);
  }
  return world;
}

bool grows(const World& start, const std::string& method, Settings settings, double step) {
  settings["step"] = step;
  Simulation simulation(start, make_method(method, settings));
  try {
    simulation.advance_to(step * static_cast<double>(kSteps));
  } catch (const Diverged&) {
    return true;
  }
  for (std::size_t i = 0; i <= kBeads; ++i) {
    const Vec3 moved =
        simulation.world().connectors[0].position[i] - start.connectors[0].position[i];
    if (!(moved.norm() < kGrown * kKick)) return true;
  }
  return false;
}

void expect_boundary(const std::string& method, const Settings& settings, double stiffness) {
  const MethodInfo& info = *find_method(method);
  const World world = hanging(stiffness);
  const double limit = info.longest_step(world, with_defaults(info, settings));
  EXPECT_FALSE(grows(world, method, settings, 0.9 * limit)) << method << ", limit " << limit;
  EXPECT_TRUE(grows(world, method, settings, 1.1 * limit)) << method << ", limit " << limit;
}

Settings springs(const char* integrator, double stiffness, double damping) {
  return {{"integrator", std::string(integrator)}, {"stiffness", stiffness}, {"damping", damping}};
}

TEST(Boundary, OfSpringsIsThatOfTheFastestStretch) {
  for (const double stiffness : {1e3, 1e5}) {
    expect_boundary("springs", springs("semi-implicit-euler", stiffness, 0.1), stiffness);
    expect_boundary("springs", springs("semi-implicit-euler", stiffness, 1), stiffness);
    expect_boundary("springs", springs("rk4", stiffness, 0.1), stiffness);
  }
}

TEST(Boundary, OfDynamicConstraintsIsThatOfTheFastestSwing) {
  const double rigid = 1e300;
  for (const char* integrator : {"semi-implicit-euler", "rk4"}) {
    expect_boundary("dynamic-constraints", {{"integrator", std::string(integrator)}}, rigid);
  }
}

// 2 sqrt(T/(m l)), T the tension at the top, bounds the fastest swing, and 2 sqrt(k/m) the fastest
// stretch: the limits are never shorter than these give.
TEST(Boundary, LimitsAreThoseOfTheTextbook) {
  const World world = worlds::chain(kBeads + 1, 1, -Vec3::UnitY());
  const double m = world.connectors[0].particle_mass[1], l = 1.0 / kBeads;
  const double swing = 2 * std::sqrt(kBeads * m * worlds::kGravity / (m * l));
  const MethodInfo& constraints = *find_method("dynamic-constraints");
  const Settings rk4 = with_defaults(constraints, {{"integrator", std::string("rk4")}});
  EXPECT_GE(constraints.longest_step(world, rk4), 2.828 / swing);
  EXPECT_LT(constraints.longest_step(world, rk4), 1.2 * 2.83 / swing);
  const MethodInfo& info = *find_method("springs");
  const Settings settings = with_defaults(info, springs("semi-implicit-euler", 1e4, 0));
  EXPECT_NEAR(info.longest_step(world, settings) * std::sqrt(1e4 / m), 1, 0.01);
}

// XPBD does not diverge: it stretches, by T dt^2/(m l) of a link that the next pulls with T. The
// top one's next carries a bead less.
TEST(Boundary, OfXpbdIsAStretchAndGoesWithTheSquareOfTheStep) {
  const MethodInfo& xpbd = *find_method("xpbd");
  const World world = worlds::chain(kBeads + 1, 1, -Vec3::UnitY());
  const double limit = xpbd.longest_step(world, with_defaults(xpbd, {}));
  const auto stretched = [&](double step) {
    Simulation simulation(world, make_method("xpbd", {{"step", step}}));
    double most = 0;  // once it has settled
    for (int i = 1; i <= 400; ++i) {
      simulation.advance_to(10 * i * step);
      if (i > 200) most = std::max(most, stretch_max(simulation.world()));
    }
    return most;
  };
  EXPECT_NEAR(stretched(limit), 0.01 * (kBeads - 1) / kBeads, 1e-4);
  EXPECT_NEAR(stretched(limit) / stretched(limit / 2), 4, 0.1);
}

// A rope let go from horizontal snaps taut again and again: tensions many times those at rest, on
// which the theory's limit is built. A step that the settings leave open has to bear them.
TEST(Boundary, OpenStepsAreStable) {
  const auto energy_gained = [](const char* method, Settings settings, std::size_t particles) {
    World world = worlds::chain(particles, 1, Vec3::UnitX());
    world.connectors[0].particle_mass.back() *= 20;
    const auto energy = [](const World& at) { return kinetic_energy(at) + potential_energy(at); };
    const double before = energy(world), scale = 20 * worlds::kGravity;
    Simulation simulation(world, make_method(method, settings));
    double most = 0;
    for (int frame = 1; frame <= 90; ++frame) {
      simulation.advance_to(frame / 60.0);
      most = std::max(most, energy(simulation.world()) - before);
    }
    return most / (scale * world.connectors[0].particle_mass[1]);
  };
  const auto euler = std::string("explicit-euler");
  for (const std::size_t particles : {5, 21, 81}) {
    EXPECT_LT(energy_gained("dynamic-constraints", {}, particles), 0.1) << particles;
    EXPECT_LT(energy_gained("springs", {}, particles), 0.1) << particles;
    EXPECT_LT(energy_gained("springs", {{"integrator", std::string("rk4")}}, particles), 0.1);
  }
  EXPECT_LT(energy_gained("springs", {{"integrator", euler}}, 5), 0.1);
}

// Energy that the links hold counts too. Explicit Euler multiplies the energy of a swing w by
// 1 + (w dt)^2 in each step: the gain is in proportion to the step.
TEST(Boundary, ExplicitEulerWithoutDampingGainsEnergyAtAnyStep) {
  EXPECT_EQ(methods::stability_limit(methods::Integrator::explicit_euler, 0), 0);
  constexpr double stiffness = 200;
  const World world = worlds::pendulum(0.5, 60);
  const auto energy = [&](const World& at) {
    return kinetic_energy(at) + potential_energy(at) +
           stiffness / 2 * std::pow(stretch_max(at) * 0.5, 2);
  };
  const auto gained = [&](const char* integrator, double step) {
    Settings settings = springs(integrator, stiffness, 0);
    settings["step"] = step;
    Simulation simulation(world, make_method("springs", settings));
    simulation.advance_to(0.5);
    return energy(simulation.world()) - energy(world);
  };
  const double coarse = gained("explicit-euler", 1e-4), fine = gained("explicit-euler", 5e-5);
  EXPECT_GT(fine, 1e-3);
  EXPECT_NEAR(coarse / fine, 2, 0.1);
  EXPECT_LT(std::abs(gained("rk4", 1e-4)), 1e-6);
}

}  // namespace
}  // namespace taut::boundary_test
