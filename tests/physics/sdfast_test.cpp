// SD/FAST, where it is installed, against the truth.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/simulation.h"
#include "worlds.h"

namespace taut {
namespace {

class SdFast : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const MethodInfo* method = find_method("sdfast");
    ASSERT_NE(method, nullptr);
    if (!method->missing.empty()) GTEST_SKIP() << method->missing;
  }
  World after(const World& start, double time, double tolerance) const {
    const Settings settings{{"tolerance", tolerance}, {"formulation", std::string(GetParam())}};
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

double distance(const World& a, const World& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.connectors[0].particles(); ++i) {
    const Vec3 gap = a.connectors[0].position[i] - b.connectors[0].position[i];
    largest = std::max(largest, gap.norm());
  }
  return largest;
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

TEST_P(SdFast, OtherWorldsAreRefused) {
  for (const World& world : {worlds::chain_with_box(6), worlds::garland(), worlds::driven_chain(6),
                             worlds::chain(7, 1, Vec3::UnitX())}) {
    EXPECT_THROW(after(world, 0.1, 1e-3), Diverged);
  }
}

INSTANTIATE_TEST_SUITE_P(Formulations, SdFast, testing::Values("order-n", "kane"),
                         [](const auto& row) {
                           return std::string(row.param) == "kane" ? "kane" : "orderN";
                         });

}  // namespace
}  // namespace taut
