// Pins, cuts, driven ends and clamps of what stretches and bends.
#include <gtest/gtest.h>

#include "material_worlds.h"

namespace taut::material_holds_test {
namespace {

using namespace material_worlds;

/// A clamped rope of 20 links that falls, with a load at its end.
World falling(double axial) {
  World world = rope(20, 0.2, section(axial, 0.05), true);
  world.connectors[0].particle_mass.back() += 0.05;
  finish(world);
  return world;
}

/// The world, moved by a method through a pin that comes, moves and goes, and a cut.
World through_interventions(const World& start, const char* method, const Settings& settings) {
  Simulation simulation(start, make_method(method, settings));
  simulation.advance_to(0.1);
  const Pinned pin = simulation.interventions().pin(simulation.world(), 0, 0.512);
  EXPECT_EQ(pin.outcome, Outcome::done) << words(pin.outcome);
  simulation.advance_to(0.2);
  EXPECT_EQ(simulation.interventions().release(simulation.world(), pin.pin), Outcome::done);
  simulation.advance_to(0.3);
  EXPECT_EQ(simulation.interventions().cut(simulation.world(), 0, 0.8).outcome, Outcome::done);
  simulation.advance_to(0.4);
  return simulation.world();
}

TEST(MaterialHolds, PinsAndCuts) {
  for (const double axial : {300.0, kRigid}) {
    const World start = falling(axial);
    const World truth = through_interventions(start, "truth", {});
    ASSERT_EQ(truth.connectors.size(), 2u);
    EXPECT_EQ(truth.connectors[0].sections.size(), truth.connectors[0].links());
    EXPECT_EQ(truth.connectors[1].sections.size(), truth.connectors[1].links());
    EXPECT_EQ(truth.connectors[0].links() + truth.connectors[1].links(), 20u);
    const World direct = through_interventions(start, "direct", {{"tolerance", 1e-6}});
    EXPECT_LT(apart(direct, truth), 1e-5) << axial;
  }
}

/// A body that goes up and turns, and carries a clamped rope.
World carried(double axial) {
  World world = falling(axial);
  std::vector<PathKey> keys(2);
  keys[1].time = 0.5;
  keys[1].position = Vec3(0.1, 0.2, 0.1);
  keys[1].rotation = Quat(Eigen::AngleAxisd(1.0, Vec3(0, 0.6, 0.8)));
  Body hand;
  hand.name = "hand";
  hand.mass_properties = solid_cylinder(0.12, 0.3, 0.03);
  hand.path = std::make_shared<const Path>(keys);
  world.bodies = {hand};
  world.connectors[0].holds[0].to = worlds::on_body(0, Vec3::Zero());
  finish(world);
  return world;
}

TEST(MaterialHolds, DrivenClampsTurn) {
  for (const double axial : {300.0, kRigid}) {
    const World truth = after(carried(axial), 0.5, "truth", {});
    EXPECT_LT(apart(after(carried(axial), 0.5, 1e-6), truth), 1e-6);
    const Connector& end = truth.connectors[0];
    const Vec3 clamp = clamp_motion(truth, end.holds[0], 0.5).direction;
    const Vec3 link = (end.position[1] - end.position[0]).normalized();
    // Half a link bends there, under at most the moment of all weights at rest, straight out.
    const double moment = (0.05 * 1 + 0.2 / 2) * worlds::kGravity;
    EXPECT_GT(clamp.dot(link), std::cos(moment / 0.05 * 0.025));
    EXPECT_GT((clamp - Vec3::UnitX()).norm(), 0.3);
  }
}

// Truth and springs follow free bodies; with an axis through the end and the centre alone, the link
// that springs give it pulls as the truth's does.
TEST(MaterialHolds, FreeBodiesAtAnEnd) {
  World world = falling(300);
  Body box = worlds::box("box");
  const Vec3 point(0.02, 0.1, 0.03);
  box.position = world.connectors[0].position.back() - point;
  box.velocity = -box.spin.cross(point);
  world.bodies = {box};
  Hold hold;
  hold.particle = 20;
  hold.to = worlds::on_body(0, point);
  world.connectors[0].holds.push_back(hold);
  finish(world);
  const World truth = after(world, 0.2, "truth", {});
  EXPECT_NEAR(energy(truth), energy(world), 1e-9);
  const World games = after(world, 0.2, "springs", {{"step", 1.0 / 61440}});
  EXPECT_LT(apart(games, truth), 1e-3);
  for (const char* method : {"direct", "xpbd"}) {
    EXPECT_THROW(after(world, 0.2, method, {}), Diverged) << method;
  }
}

// A connector without materials beside one that has some moves as it does alone, to the last bit.
TEST(MaterialHolds, TheRestOfTheWorldMovesAsBefore) {
  World both = falling(300), alone = worlds::chain(11, 0.5, Vec3(1, -0.2, 0.3));
  both.connectors.push_back(alone.connectors[0]);
  finish(both);
  const World moved = after(both, 0.5, 1e-5), bare = after(alone, 0.5, 1e-5);
  EXPECT_EQ(moved.connectors[1].position, bare.connectors[0].position);
}

// Thrown at what holds it, the lower link is at the upper one's end after 0.1 s. Which way it goes
// on from there nothing tells.
TEST(MaterialHolds, ALinkThatIsPressedToNothingEndsTheRun) {
  World world = rope(2, 0.2, section(0.01, 1e-6), false);
  world.gravity = Vec3::Zero();
  Connector& thrown = world.connectors[0];
  thrown.velocity.back() = 5 * (thrown.position[1] - thrown.position[2]).normalized();
  try {
    make_method("direct", {})->advance(world, 1);
    FAIL();
  } catch (const Diverged& stop) {
    EXPECT_EQ(stop.link, 1u);
    EXPECT_NE(std::string(stop.what()).find("a link is pressed together to nothing"),
              std::string::npos)
        << stop.what();
    EXPECT_NEAR(stop.time, 0.1, 0.002);
  }
}

TEST(MaterialHolds, TheSameBitsTwice) {
  const World first = after(falling(300), 0.3, 1e-5), second = after(falling(300), 0.3, 1e-5);
  EXPECT_EQ(first.connectors[0].position, second.connectors[0].position);
}

}  // namespace
}  // namespace taut::material_holds_test
