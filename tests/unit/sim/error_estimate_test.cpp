// The effect of an error estimate on a simulation (none), and its message where it cannot tell.
#include "sim/run/error_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/worlds.h"

namespace taut::error_estimate_test {
namespace {

struct Ended {
  std::uint64_t hash = 0;
  Counters counters;
};

/// Half a second of a swing, frame by frame; `follow` sees each.
Ended swing(const World& world, std::string_view method, const Settings& settings,
            const auto& follow) {
  Simulation simulation(world, make_method(method, settings));
  for (int k = 0; k <= 30; ++k) {
    simulation.advance_to(k / 60.0);
    follow(simulation);
  }
  return {state_hash(simulation.world()), simulation.method().counters()};
}

World chain() {
  return worlds::chain(6, 1, worlds::from_down(60));
}

TEST(ErrorEstimate, LeavesEveryBitOfTheRun) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    ErrorEstimate estimate(chain(), method.name, {});
    const auto follow = [&](const Simulation& simulation) { estimate.follow(simulation); };
    const Ended with = swing(chain(), method.name, {}, follow);
    const Ended without = swing(chain(), method.name, {}, [](const Simulation&) {});
    EXPECT_EQ(with.hash, without.hash) << method.name;
    EXPECT_EQ(with.counters.steps, without.counters.steps) << method.name;
    EXPECT_EQ(estimate.none().empty(), estimate.error() > 0) << method.name;
  }
}

TEST(ErrorEstimate, SaysByNameWhereThereIsNone) {
  const std::pair<const char*, Settings> without[] = {
      {"impulse", {}}, {"springs", {}}, {"sdfast", {}}, {"multibody", {{"accuracy", 0.5}}}};
  for (const auto& [method, settings] : without) {
    if (!find_method(method)->missing.empty()) continue;
    ErrorEstimate estimate(chain(), method, settings);
    EXPECT_EQ(estimate.none().rfind(std::string(method) + " ", 0), 0u) << estimate.none();
    swing(chain(), method, settings, [&](const Simulation& s) { estimate.follow(s); });
    EXPECT_TRUE(std::isnan(estimate.error())) << method;
    EXPECT_FALSE(estimate.predictable_until()) << method;
  }
  EXPECT_THROW(ErrorEstimate(chain(), "springs", {{"stepp", 1.0}}), std::invalid_argument);
}

TEST(ErrorEstimate, IsHeldAgainstTheToleranceOrAHundredthOfTheLongestConnector) {
  World world = chain();
  world.connectors.push_back(world.connectors[0]);
  world.connectors[1].length = 3;
  EXPECT_EQ(ErrorEstimate(world, "direct", {{"tolerance", 2e-3}}).limit(), 2e-3);
  EXPECT_EQ(ErrorEstimate(world, "direct", {{"step", 1.0 / 60}}).limit(), 0.03);
  EXPECT_EQ(ErrorEstimate(world, "xpbd", {}).limit(), 0.03);
  EXPECT_EQ(ErrorEstimate(world, "multibody", {}).limit(), 0.03) << "its accuracy is no length";
}

TEST(ErrorEstimate, TheFirstTimeAboveTheLimitStays) {
  const Settings rough{{"step", 1.0 / 240}};
  ErrorEstimate estimate(chain(), "xpbd", rough);
  double first = -1, largest = 0;
  swing(chain(), "xpbd", rough, [&](const Simulation& simulation) {
    estimate.follow(simulation);
    largest = std::max(largest, estimate.error());
    if (first < 0 && estimate.error() > estimate.limit()) first = simulation.world().time;
    EXPECT_EQ(estimate.predictable_until().value_or(-1), first);
    EXPECT_EQ(estimate.largest(), largest);
  });
  EXPECT_GT(first, 0);
  ErrorEstimate fine(chain(), "xpbd", {{"step", 1.0 / 60000}});
  swing(chain(), "xpbd", {{"step", 1.0 / 60000}}, [&](const Simulation& s) { fine.follow(s); });
  EXPECT_FALSE(fine.predictable_until());
}

TEST(ErrorEstimate, ARunGoesOnWhereTheCoarserOneDiverges) {
  // Stable up to a step of 2 / w, w the fastest stretch, without damping.
  const double fastest = 2 * std::sqrt(1e4 / (1.0 / 6));
  const Settings settings{{"step", 1.5 / fastest}, {"damping", 0.0}};
  ErrorEstimate estimate(chain(), "springs", settings);
  const Ended with = swing(chain(), "springs", settings,
                           [&](const Simulation& simulation) { estimate.follow(simulation); });
  EXPECT_EQ(with.hash, swing(chain(), "springs", settings, [](const Simulation&) {}).hash);
  EXPECT_EQ(estimate.none(), "");
  EXPECT_NE(estimate.diverged().find("springs"), std::string::npos) << estimate.diverged();
  EXPECT_TRUE(std::isinf(estimate.error()));
  EXPECT_TRUE(std::isinf(estimate.largest()));
  ASSERT_TRUE(estimate.predictable_until());
  EXPECT_LT(*estimate.predictable_until(), 0.5);
}

TEST(ErrorEstimate, StepsOfAFrameAreComparedEveryFour) {
  const Settings settings{{"step", 1.0 / 60}};
  ErrorEstimate estimate(chain(), "dynamic-constraints", settings);
  std::vector<double> errors;
  swing(chain(), "dynamic-constraints", settings, [&](const Simulation& simulation) {
    estimate.follow(simulation);
    errors.push_back(estimate.error());
  });
  for (std::size_t k = 4; k < errors.size(); ++k) {
    EXPECT_EQ(errors[k] != errors[k - 1], k % 4 == 0) << k;
  }
}

TEST(ErrorEstimate, FramesThatAFinerCompanionSeesAreEveryFourthAndMoreAtFirst) {
  ErrorEstimate estimate(chain(), "direct", {});
  std::vector<double> errors;
  swing(chain(), "direct", {}, [&](const Simulation& simulation) {
    estimate.follow(simulation);
    errors.push_back(estimate.error());
  });
  std::vector<std::size_t> compared;
  for (std::size_t k = 1; k < errors.size(); ++k) {
    if (errors[k] != errors[k - 1]) compared.push_back(k);
  }
  EXPECT_EQ(compared, (std::vector<std::size_t>{1, 2, 3, 5, 9, 13, 17, 21, 25, 29}));
}

TEST(ErrorEstimate, ParticlesCountWhereThereAreAnyAndBodiesByTheirEndsWhereThereAreNone) {
  Body box;
  box.mass_properties = solid_box(0.12, Vec3(0.30, 0.1, 0.02));
  box.spin = Vec3(1, 20, 3);
  World alone;
  alone.bodies = {box};
  World beside = chain();
  beside.bodies = {box};
  for (World* world : {&alone, &beside}) finish(*world);
  const auto error = [](const World& world) {
    const Settings steps{{"step", 1.0 / 960}};
    ErrorEstimate estimate(world, "dynamic-constraints", steps);
    swing(world, "dynamic-constraints", steps, [&](const Simulation& s) { estimate.follow(s); });
    return estimate.error();
  };
  EXPECT_GT(error(alone), 0);
  EXPECT_EQ(error(beside), error(chain()));
}

/// A rope of strings with a weight, thrown up: it falls and snaps taut.
World falling_string() {
  World world = worlds::chain(4, 1, worlds::from_down(175));
  Connector& rope = world.connectors[0];
  rope.pulls = true;
  rope.particle_mass.back() += 0.5;
  finish(world);
  return world;
}

/// A chain that swings down onto a ball.
World chain_on_a_ball() {
  World world = worlds::chain(10, 1, worlds::from_down(80));
  world.connectors[0].radius = 0.005;
  Obstacle ball;
  ball.name = "ball";
  ball.shape = sphere_shape(0.1);
  ball.place.position = Vec3(0.1, -0.5, 0);
  world.obstacles = {ball};
  finish(world);
  return world;
}

TEST(ErrorEstimate, TellsWhatStringsAndContactErr) {
  constexpr double kTolerance = 1e-4;
  for (const World& world : {falling_string(), chain_on_a_ball()}) {
    const Settings settings{{"tolerance", kTolerance}};
    Simulation simulation(world, make_method("direct", settings));
    Simulation truth(world, make_method("direct", {{"tolerance", kTolerance / 1000}}));
    ErrorEstimate estimate(world, "direct", settings);
    double largest = 0;
    for (int k = 0; k <= 60; ++k) {
      for (Simulation* each : {&simulation, &truth}) each->advance_to(k / 60.0);
      estimate.follow(simulation);
      double sum = 0;
      const Connector &found = simulation.world().connectors[0],
                      &exact = truth.world().connectors[0];
      for (std::size_t i = 0; i < found.particles(); ++i) {
        sum += (found.position[i] - exact.position[i]).squaredNorm();
      }
      largest = std::max(largest, std::sqrt(sum / double(found.particles())));
    }
    EXPECT_GT(largest, kTolerance / 1000);
    EXPECT_GT(estimate.largest(), largest / 3);
    EXPECT_LT(estimate.largest(), largest * 3);
  }
}

TEST(ErrorEstimate, InterventionsThatItDoesNotKnowAreAMistake) {
  Simulation simulation(chain(), make_method("xpbd", {}));
  ErrorEstimate estimate(chain(), "xpbd", {});
  simulation.interventions().pin(simulation.world(), 0, 0.5);
  simulation.advance_to(0.1);
  EXPECT_THROW(estimate.follow(simulation), std::invalid_argument);
}

TEST(ErrorEstimate, EndsOfABodyAreAsFarAsAStickIsLong) {
  const MassProperties stick = solid_cylinder(0.12, 0.30, 0.028);
  double farthest = 0;
  for (const Vec3& end : box_ends(stick)) farthest = std::max(farthest, end.norm());
  // A box of a thin rod's moment is as long but for its thickness.
  EXPECT_NEAR(farthest, 0.15, 0.15 * 0.028 * 0.028 / 0.30 / 0.30);
}

}  // namespace
}  // namespace taut::error_estimate_test
