// SD/FAST, where it is installed, against the truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::sdfast_test {
namespace {

class SdFast : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const MethodInfo* method = find_method("sdfast");
    ASSERT_NE(method, nullptr);
    if (!method->missing.empty()) GTEST_SKIP() << method->missing;
  }
  World after(const World& start, double time, double tolerance,
              const char* joints = "fewest") const {
    const Settings settings{{"tolerance", tolerance},
                            {"formulation", std::string(GetParam())},
                            {"joints", std::string(joints)}};
    Simulation simulation(start, make_method("sdfast", settings));
    for (int frame = 1; frame <= 10; ++frame) simulation.advance_to(time * frame / 10);
    return simulation.world();
  }
};

World truth(const World& start, double time) {
  Simulation simulation(start, make_method("truth", {}));
  simulation.advance_to(time);
  return simulation.world();
}

double distance(const World& a, const World& other) {
  double largest = 0;
  for (std::size_t i = 0; i < a.connectors[0].particles(); ++i) {
    const Vec3 gap = a.connectors[0].position[i] - other.connectors[0].position[i];
    largest = std::max(largest, gap.norm());
  }
  for (std::size_t b = 0; b < a.bodies.size(); ++b) {
    largest = std::max(largest, (a.bodies[b].position - other.bodies[b].position).norm());
    largest = std::max(largest, a.bodies[b].rotation.angularDistance(other.bodies[b].rotation));
  }
  return largest;
}

/// A chain that starts along x and is thrown out of every plane.
World twisted(std::size_t particles) {
  World world = worlds::chain(particles, 0.5, Vec3::UnitX());
  Connector& chain = world.connectors[0];
  const Vec3 turning(0, 3, 2);
  for (std::size_t i = 0; i < particles; ++i) chain.velocity[i] = turning.cross(chain.position[i]);
  return world;
}

/// The same chain counted from its other end.
World reversed(World world) {
  Connector& chain = world.connectors[0];
  for (Hold& hold : chain.holds) hold.particle = chain.links() - hold.particle;
  std::ranges::reverse(chain.holds);
  std::ranges::reverse(chain.rest);
  std::ranges::reverse(chain.particle_mass);
  std::ranges::reverse(chain.position);
  std::ranges::reverse(chain.velocity);
  return world;
}

// Errors of tenths of a second follow the tolerance, which is of angles and their rates in a step;
// some ten steps add theirs.
TEST_P(SdFast, SwingsComeToTheTruth) {
  World loaded = worlds::chain(21, 0.2, Vec3(1, 0.2, 0));
  loaded.connectors[0].particle_mass.back() += 0.2;
  for (const World& world :
       {worlds::chain(6, 0.5, Vec3::UnitX()), worlds::chain(21, 0.5, Vec3(0.3, -1, 0.4)), loaded}) {
    const World exact = truth(world, 0.4);
    for (const double tolerance : {1e-4, 1e-7}) {
      EXPECT_LT(distance(after(world, 0.4, tolerance), exact), 100 * tolerance) << tolerance;
    }
  }
}

TEST_P(SdFast, APendulumHasItsPeriod) {
  const World world = worlds::pendulum(0.5, 90);
  const double period =
      worlds::period_ratio(90) * 2 * std::numbers::pi * std::sqrt(0.5 / worlds::kGravity);
  EXPECT_LT(distance(after(world, period, 1e-9), world), 1e-7);
}

// A model's numbers are global: two users take turns.
TEST_P(SdFast, TwoSimulationsDoNotMixTheirNumbers) {
  const Settings settings{{"tolerance", 1e-7}, {"formulation", std::string(GetParam())}};
  const World light = worlds::chain(6, 0.5, Vec3::UnitX()),
              slow = worlds::chain(6, 2, Vec3::UnitX());
  Simulation first(light, make_method("sdfast", settings));
  Simulation second(slow, make_method("sdfast", settings));
  for (int frame = 1; frame <= 10; ++frame) {
    first.advance_to(0.03 * frame);
    second.advance_to(0.03 * frame);
  }
  EXPECT_LT(distance(first.world(), truth(light, 0.3)), 1e-5);
  EXPECT_LT(distance(second.world(), truth(slow, 0.3)), 1e-5);
}

// As above: the angles of some ten links add their errors in some ten steps, and bodies turn.
TEST_P(SdFast, MotionsInSpaceComeToTheTruth) {
  World loose = twisted(6), one_body = worlds::chain_with_box(6);
  loose.connectors[0].holds.clear();
  one_body.connectors[0].holds.erase(one_body.connectors[0].holds.begin());
  World loaded = twisted(2);
  loaded.connectors[0].particle_mass.back() += 0.2;
  const std::vector<World> starts{twisted(6),
                                  loaded,
                                  loose,
                                  one_body,
                                  worlds::chain_with_box(6),
                                  worlds::driven_chain(6),
                                  worlds::thrown(6),
                                  worlds::thrown(2)};
  for (std::size_t i = 0; i < starts.size(); ++i) {
    for (const World& world : {starts[i], reversed(starts[i])}) {
      const World exact = truth(world, 0.4);
      for (const double tolerance : {1e-4, 1e-7}) {
        EXPECT_LT(distance(after(world, 0.4, tolerance), exact), 100 * tolerance)
            << "start " << i << " at " << tolerance;
      }
    }
  }
}

TEST_P(SdFast, BallJointsMoveInAPlaneAsPinsDo) {
  const World world = worlds::chain(6, 0.5, Vec3::UnitX());
  EXPECT_LT(distance(after(world, 0.4, 1e-8, "ball"), after(world, 0.4, 1e-8)), 1e-6);
}

TEST_P(SdFast, DrivenEndsAreWhereTheyAreDriven) {
  const World end = after(worlds::driven_chain(6), 0.4, 1e-3);
  const PointMotion hand = hold_motion(end, end.connectors[0].holds[0].to, 0.4);
  EXPECT_EQ(end.connectors[0].position[0], hand.position);
  EXPECT_EQ(end.connectors[0].velocity[0], hand.velocity);
}

// Velocities changed from outside are taken up again, out of the plane too.
TEST_P(SdFast, ChangedVelocitiesAreTakenUp) {
  const Settings settings{{"tolerance", 1e-8}, {"formulation", std::string(GetParam())}};
  const auto method = make_method("sdfast", settings), judge = make_method("truth", {});
  World world = worlds::chain(6, 0.5, Vec3::UnitX()), exact = world;
  for (int part = 1; part <= 2; ++part) {
    method->advance(world, 0.1 * part);
    judge->advance(exact, 0.1 * part);
    for (World* moved : {&world, &exact}) {
      Connector& chain = moved->connectors[0];
      for (std::size_t i = 1; i < 6; ++i)
        chain.velocity[i] += Vec3::UnitY().cross(chain.position[i]);
    }
  }
  method->advance(world, 0.3);
  judge->advance(exact, 0.3);
  EXPECT_LT(distance(world, exact), 1e-6);
}

TEST_P(SdFast, WhatItDoesNotFollowIsRefusedByName) {
  World lone = worlds::chain(6, 1, Vec3::UnitX()), both = lone;
  lone.bodies.push_back(worlds::box("lone"));
  both.connectors[0].holds.push_back({5, worlds::fixed_at(both.connectors[0].position[5])});
  World pinned = lone, massless = worlds::chain(6, 1, Vec3::UnitX(), 0);
  pinned.bodies.clear();
  pinned.connectors[0].holds.push_back({3, worlds::fixed_at(pinned.connectors[0].position[3])});
  const std::vector<std::pair<World, std::string>> rows{
      {worlds::garland(), "one connector alone"},
      {lone, "no body beside the chain"},
      {both, "two ends move as they are told"},
      {pinned, "pinned between its ends"},
      {massless, "no particles without mass"},
      {worlds::chain(7, 1, Vec3::UnitX()), "without a model of 6 links with pins"}};
  for (const auto& [world, said] : rows) {
    try {
      after(world, 0.1, 1e-3);
      ADD_FAILURE() << "taken: " << said;
    } catch (const Diverged& error) {
      EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formulations, SdFast, testing::Values("order-n", "kane"),
                         [](const auto& row) {
                           return std::string(row.param) == "kane" ? "kane" : "orderN";
                         });

}  // namespace
}  // namespace taut::sdfast_test
