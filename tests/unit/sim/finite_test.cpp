// States that are not finite: none leaves a simulation, and no measure hides one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::finite_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A method that spoils the world with its second step.
class Spoils : public Method {
 public:
  explicit Spoils(std::function<void(World&)> spoil) : spoil_(std::move(spoil)) {}
  void advance(World& world, double until) override {
    place_held(world, until);
    if (++counters_.steps == 2) spoil_(world);
  }

 private:
  std::function<void(World&)> spoil_;
};

TEST(Finite, AStateThatIsNotEndsTheRun) {
  struct Case {
    std::string name;
    std::size_t link;
    std::function<void(World&)> spoil;
  };
  for (const Case& spoilt : std::vector<Case>{
           {"chain", 3, [](World& world) { world.connectors[0].position[3].y() = kNan; }},
           {"chain", 2, [](World& world) { world.connectors[0].velocity[2].x() = INFINITY; }},
           {"box", 0, [](World& world) { world.bodies[0].position.z() = kNan; }},
           {"box", 0, [](World& world) { world.bodies[0].rotation.w() = kNan; }},
           {"box", 0, [](World& world) { world.bodies[0].spin.y() = -INFINITY; }},
           {"box", 0, [](World& world) { world.bodies[0].velocity.y() = kNan; }}}) {
    Simulation simulation(worlds::chain_with_box(6), std::make_unique<Spoils>(spoilt.spoil));
    simulation.advance_to(0.25);
    try {
      simulation.advance_to(0.5);
      ADD_FAILURE() << spoilt.name;
    } catch (const Diverged& error) {
      EXPECT_EQ(error.time, 0.5);
      EXPECT_EQ(error.step, 2u);
      EXPECT_EQ(error.connector, spoilt.name);
      EXPECT_EQ(error.link, spoilt.link);
      EXPECT_NE(std::string(error.what()).find("not finite"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(spoilt.name), std::string::npos) << error.what();
    }
  }
}

TEST(Finite, MeasuresOfWhatIsNotAreNot) {
  World world = worlds::chain_with_box(6);
  EXPECT_LT(stretch_max(world), 1e-12);
  world.connectors[0].position[2].x() = kNan;
  EXPECT_TRUE(std::isnan(stretch_max(world)));
  EXPECT_TRUE(std::isnan(energy(world)));
  EXPECT_TRUE(std::isnan(larger(kNan, 1)));
  EXPECT_TRUE(std::isnan(larger(1, kNan)));
  EXPECT_EQ(larger(1, 2), 2);
}

}  // namespace
}  // namespace taut::finite_test
