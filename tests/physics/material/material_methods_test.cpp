// Methods that follow what stretches, bends and meets the air: how near they are to the truth.
#include <gtest/gtest.h>

#include "material_worlds.h"
#include "sim/truth/truth.h"

namespace taut::material_methods_test {
namespace {

using namespace material_worlds;

/// A rope of 20 links that falls aslant out of the plane of x and y, its end heavier.
World falling(const Section& made, bool clamped, const Drag& drag = {}) {
  World world = rope(20, 0.2, made, clamped);
  Connector& connector = world.connectors[0];
  const Vec3 direction = Vec3(1, 0, 0.3).normalized();
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    connector.position[i] = static_cast<double>(i) / 20 * direction;
  }
  if (clamped) connector.holds[0].clamp = direction;
  connector.particle_mass.back() += 0.05;
  connector.drag = drag;
  if (drag.across > 0) world.air = {1.2, Vec3(1, 0, 2)};
  finish(world);
  return world;
}

Section damped(double axial, double bending) {
  Section made = section(axial, bending);
  if (std::isfinite(axial)) made.axial_damping = 1e-3 * axial;
  made.bending_damping = 0.01 * bending;
  return made;
}

struct Case {
  const char* name;
  World world;
};

std::vector<Case> cases() {
  return {{"stretch", falling(section(500, 0), false)},
          {"bending", falling(section(kRigid, 0.02), false)},
          {"clamped", falling(section(kRigid, 0.1), true)},
          {"both", falling(section(1000, 0.5), true)},
          {"damped", falling(damped(300, 0.05), true)},
          {"air", falling(section(kRigid, 0), false, {1.2, 0.1})},
          {"all", falling(damped(300, 0.05), true, {1.2, 0.1})}};
}

// The tolerance is what the user gets, in each.
TEST(MaterialMethods, DirectKeepsToItsTolerance) {
  for (const Case& each : cases()) {
    const World truth = after(each.world, 0.5, "truth", {});
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      EXPECT_LT(apart(after(each.world, 0.5, tolerance), truth), tolerance)
          << each.name << " " << tolerance;
    }
  }
}

// Radau IIA: of order 5 from below where the rope is soft, from above where rounding does not count
// yet.
TEST(MaterialMethods, DirectIsOfFifthOrder) {
  const World start = falling(section(10, 0.002), false, {1.2, 0.1});
  const World truth = after(start, 0.3, "truth", {});
  const double coarse = apart(after(start, 0.3, "direct", {{"step", 1.0 / 120}}), truth);
  const double fine = apart(after(start, 0.3, "direct", {{"step", 1.0 / 480}}), truth);
  const double order = std::log2(coarse / fine) / 2;
  EXPECT_GT(order, 4.6);
  EXPECT_LT(order, 5.4);
}

// Of first order in the step, or better where stiff ways to move are what is off; rigid links are
// springs of their own in both.
TEST(MaterialMethods, GamesMethodsConvergeToTheTruth) {
  for (const char* method : {"springs", "xpbd"}) {
    for (const Case& each : cases()) {
      if (!each.world.connectors[0].stretches()) continue;
      const World truth = after(each.world, 0.3, "truth", {});
      const double coarse = apart(after(each.world, 0.3, method, {{"step", 1.0 / 7680}}), truth);
      const double fine = apart(after(each.world, 0.3, method, {{"step", 1.0 / 30720}}), truth);
      EXPECT_LT(fine, 1e-2) << method << " " << each.name;
      EXPECT_GT(coarse / fine, 2.5) << method << " " << each.name;
    }
  }
}

// A stiff cantilever of many links sags by w L^4 / (8 EI) and the share of links that bend at their
// ends; a pass over its bends alone does not hold it.
TEST(MaterialMethods, ACantileverSagsByXpbdAsByTheTruth) {
  constexpr std::size_t kParticles = 41;
  Connector rod = straight_connector("rod", 1, 0.1, kParticles, Vec3(0, 2, 0), Vec3::UnitX());
  rod.sections.assign(rod.links(), {.bending_stiffness = 30, .bending_damping = 1.5});
  rod.holds = {{0, worlds::fixed_at(rod.position[0])}};
  rod.holds[0].clamp = Vec3::UnitX();
  World world;
  world.connectors = {rod};
  finish(world);
  const double truth = 0.1 * worlds::kGravity / (8 * 30);
  const auto error = [&](const Settings& settings) {
    return std::abs(2 - after(world, 1, "xpbd", settings).connectors[0].position.back().y() -
                    truth);
  };
  EXPECT_LT(error({}), 0.01);
  EXPECT_LT(error({{"step", 1e-4}, {"iterations", 16.0}}), 0.003);
}

// The step that springs choose by themselves is stable, however stiff.
TEST(MaterialMethods, SpringsStayStable) {
  for (const double bending : {0.01, 1.0, 100.0}) {
    const World end = after(falling(section(1e4, bending), true), 1, "springs", {});
    EXPECT_LT(end.connectors[0].position.back().norm(), 1.2) << bending;
  }
}

TEST(MaterialMethods, TheTwoSolversOfTheTruthAgree) {
  const std::vector<double> times{0.1, 0.2, 0.3};
  const truth::Reference truth =
      truth::solve_truth(falling(damped(300, 0.05), true, {1.2, 0.1}), times);
  EXPECT_EQ(truth.horizon, 0.3);
  EXPECT_LT(truth.self_error, 1e-6);
}

// A rope of sections that name nothing, and one whose stiffness goes to zero, move as a rope
// without any.
TEST(MaterialMethods, WithoutStiffnessTheyMoveAsBefore) {
  World bare = falling(section(kRigid, 0), false);
  for (const double bending : {0.0, 1e-10}) {
    const World soft = after(falling(section(kRigid, bending), false), 0.5, 1e-6);
    World plain = bare;
    plain.connectors[0].sections.clear();
    finish(plain);
    EXPECT_LT(apart(soft, after(plain, 0.5, 1e-6)), 2e-6) << bending;
  }
}

// From next to nothing to a thousand million times the weight's own: what a run costs stays, and
// energy never rises by more than the tolerance is worth.
TEST(MaterialMethods, NoStiffnessCollapsesTheStep) {
  const double weight = 0.25 * worlds::kGravity, tolerance = 1e-4;
  for (const bool clamped : {false, true}) {
    for (const double bending : {1e-3, 1.0, 1e3, 1e6, 1e9}) {
      const World start = falling(section(kRigid, bending * weight), clamped);
      Simulation simulation(start, make_method("direct", {{"tolerance", tolerance}}));
      for (int frame = 1; frame <= 60; ++frame) {
        simulation.advance_to(frame / 60.0);
        EXPECT_LT(energy(simulation.world()) - energy(start), tolerance * energy_scale(start));
      }
      EXPECT_LT(simulation.method().counters().steps, 2000u) << bending << clamped;
    }
  }
  for (const double axial : {1e-3, 1.0, 1e3, 1e6, 1e9, 1e12}) {
    const World start = falling(section(axial, 0), false);
    Simulation simulation(start, make_method("direct", {{"tolerance", tolerance}}));
    for (int frame = 1; frame <= 30; ++frame) {
      simulation.advance_to(frame / 60.0);
      EXPECT_LT(energy(simulation.world()) - energy(start), tolerance * energy_scale(start));
    }
    EXPECT_LT(simulation.method().counters().steps, 2000u) << axial;
  }
}

TEST(MaterialMethods, OthersRefuseByName) {
  const World start = falling(section(kRigid, 0.1), false);
  for (const MethodInfo& method : all_methods()) {
    if (method.abilities.follows.has(Feature::bending) || !method.missing.empty()) continue;
    World world = start;
    try {
      make_method(method.name, {})->advance(world, 0.01);
      ADD_FAILURE() << method.name;
    } catch (const Diverged& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("does not follow bending (connector"),
                std::string::npos)
          << refusal.what();
    }
  }
}

// Damping alone limits an explicit step as stiffness does.
TEST(MaterialMethods, BendingDampingAloneIsStable) {
  for (const char* integrator : {"semi-implicit-euler", "rk4"}) {
    World world = worlds::chain(31, 1, Vec3::UnitX());
    Connector& rope = world.connectors[0];
    Section section;
    section.bending_damping = 0.1;
    rope.sections.assign(rope.links(), section);
    world.topology = structure(world);
    Simulation simulation(world, make_method("springs", {{"integrator", std::string(integrator)}}));
    const double start = energy(simulation.world());
    simulation.advance_to(0.2);
    EXPECT_LT(energy(simulation.world()), start + 1e-3) << integrator;
  }
}

}  // namespace
}  // namespace taut::material_methods_test
