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

/// A box at the end of what falls, which turns it.
World laden(double axial, double drag) {
  World world = falling(axial);
  Body box = worlds::box("box");
  const Vec3 point(0.02, 0.1, 0.03);
  box.position = world.connectors[0].position.back() - point;
  box.velocity = -box.spin.cross(point);
  world.bodies = {box};
  Hold hold;
  hold.particle = 20;
  hold.to = worlds::on_body(0, point);
  world.connectors[0].holds.push_back(hold);
  world.connectors[0].drag = {drag, drag / 10};
  if (drag > 0) world.air = {1.2, Vec3(1, 0, 2)};
  finish(world);
  return world;
}

double bodies_apart(const World& a, const World& b) {
  return (a.bodies[0].position - b.bodies[0].position).norm() +
         0.1 * a.bodies[0].rotation.angularDistance(b.bodies[0].rotation);
}

// Energy is kept where there is no air; direct keeps to its tolerance, and games' methods, of first
// order in the step, come near.
TEST(MaterialHolds, FreeBodiesAtAnEnd) {
  for (const double axial : {300.0, kRigid}) {
    for (const double drag : {0.0, 1.2}) {
      SCOPED_TRACE(testing::Message() << axial << " N, drag " << drag);
      const World world = laden(axial, drag);
      const World truth = after(world, 0.2, "truth", {});
      if (drag == 0) {
        EXPECT_NEAR(energy(truth), energy(world), 1e-9);
      }
      for (const double tolerance : {1e-3, 1e-6}) {
        const World direct = after(world, 0.2, tolerance);
        EXPECT_LT(apart(direct, truth), tolerance);
        EXPECT_LT(bodies_apart(direct, truth), 2 * tolerance);
      }
      if (std::isfinite(axial)) {
        EXPECT_LT(apart(after(world, 0.2, "springs", {{"step", 1.0 / 61440}}), truth), 1e-3);
      }
      const auto off = [&](double step) {
        const World games = after(world, 0.2, "xpbd", {{"step", step}});
        return apart(games, truth) + bodies_apart(games, truth);
      };
      const double coarse = off(1.0 / 15360), fine = off(1.0 / 61440);
      EXPECT_LT(fine, 5e-3);
      EXPECT_GT(coarse / fine, 2.5);
    }
  }
}

// A bow with a box at both ends, let go in free space: what it had of momentum, of angular momentum
// and of energy stays.
TEST(MaterialHolds, ABodyAtBothEnds) {
  World world = rope(20, 0.2, section(300, 0.05), false);
  world.gravity.setZero();
  Connector& bow = world.connectors[0];
  constexpr double kRadius = 0.2;
  const double turn = 2 * std::asin(bow.rest[0] / 2 / kRadius);
  for (std::size_t i = 0; i < bow.particles(); ++i) {
    const double angle = turn * (static_cast<double>(i) - 10);
    bow.position[i] = kRadius * Vec3(std::sin(angle), std::cos(angle), 0);
  }
  Body box = worlds::box("box");
  box.position = (bow.position.front() + bow.position.back()) / 2 + Vec3(0, -0.03, 0.02);
  box.rotation = Quat::Identity();
  box.velocity = Vec3(0.1, 0, 0.3);
  box.spin = Vec3(0.5, 2, 0);
  world.bodies = {box};
  bow.holds.clear();
  for (const std::size_t end : {std::size_t{0}, std::size_t{20}}) {
    const Vec3 arm = bow.position[end] - box.position;
    bow.velocity[end] = box.velocity + box.spin.cross(arm);
    Hold hold;
    hold.particle = end;
    hold.to = worlds::on_body(0, arm);
    bow.holds.push_back(hold);
  }
  finish(world);
  const World truth = after(world, 0.3, "truth", {}), direct = after(world, 0.3, 1e-6);
  EXPECT_LT(apart(direct, truth), 1e-6);
  EXPECT_LT(bodies_apart(direct, truth), 2e-6);
  EXPECT_LT((linear_momentum(direct) - linear_momentum(world)).norm(), 1e-9);
  const Vec3 turning = angular_momentum(world, Vec3::Zero());
  EXPECT_LT((angular_momentum(direct, Vec3::Zero()) - turning).norm(), 1e-6 * turning.norm());
  EXPECT_NEAR(energy(direct), energy(world), 1e-5 * energy(world));
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

// The part of a rope between two places at its full length cannot move; the rest hangs on.
TEST(MaterialHolds, RopeThatIsHeldAtItsFullLengthStays) {
  World world = worlds::chain(9, 1, worlds::from_down(0), 0.1);
  Connector& rope = world.connectors[0];
  Section section;
  section.bending_damping = 1e-6;
  rope.sections.assign(rope.links(), section);
  rope.holds.push_back({5, worlds::fixed_at(rope.position[5])});
  for (const int i : {6, 7, 8}) rope.velocity[std::size_t(i)] = 0.1 * (i - 5) * Vec3::UnitX();
  finish(world);
  const World end = material_worlds::after(world, 0.3, 1e-4);
  for (std::size_t i = 0; i <= 5; ++i) {
    EXPECT_LT((end.connectors[0].position[i] - rope.position[i]).norm(), 1e-9) << i;
  }
  EXPECT_GT(std::abs(end.connectors[0].position[8].x()), 0.01);
}

}  // namespace
}  // namespace taut::material_holds_test
