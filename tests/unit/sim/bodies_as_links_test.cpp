#include <gtest/gtest.h>

#include "sim/measure/measure.h"
#include "sim/run/reduced.h"
#include "sim/run/simulation.h"

namespace taut::bodies_as_links_test {
namespace {

Attachment on_body(std::size_t body, const Vec3& point) {
  Attachment to;
  to.kind = Attachment::Kind::body;
  to.body = body;
  to.point = point;
  return to;
}

/// A chain from a fixed point to the end of a body that is not in one line with it and turns out of
/// their plane, but not about its own axis. `reversed`: the chain's first particle is on the body.
World hung(const MassProperties& properties, bool reversed) {
  World world;
  Body body;
  body.name = "body";
  body.mass_properties = properties;
  const Vec3 corner(0.2, 0, 0);
  body.position = corner + Vec3(0, -0.15, 0);
  body.spin = {2, 0, 1};
  body.velocity = body.spin.cross(body.position - corner);  // its end is at rest
  world.bodies.push_back(body);
  const Vec3 start = reversed ? corner : Vec3(0, 0, 0);
  Connector chain =
      straight_connector("chain", 0.2, 0.05, 6, start, reversed ? Vec3(-1, 0, 0) : Vec3(1, 0, 0));
  const std::size_t held = reversed ? 5 : 0, hangs = reversed ? 0 : 5;
  chain.holds = {{0, {}}, {5, {}}};
  for (Hold& hold : chain.holds) {
    if (hold.particle == hangs) hold.to = on_body(0, {0, 0.15, 0});
    if (hold.particle == held) hold.to.point = {0, 0, 0};
  }
  world.connectors.push_back(std::move(chain));
  finish(world);
  return world;
}

/// How far (m) the ends of the body's axis and the particles come apart in half a second.
double apart(const World& rigid) {
  World linked = rigid;
  linked.bodies[0].model = BodyModel::link;
  const Settings finely{{"tolerance", 1e-9}};
  Simulation a(rigid, make_method("direct", finely)), b(linked, make_method("direct", finely));
  double most = 0;
  for (int k = 0; k <= 60; ++k) {
    a.advance_to(k / 120.0);
    b.advance_to(k / 120.0);
    const Snapshot p = a.state(), q = b.state();
    EXPECT_EQ(p.connectors[0].size(), q.connectors[0].size());
    for (std::size_t i = 0; i < p.connectors[0].size(); ++i) {
      most = std::max(most, (p.connectors[0][i] - q.connectors[0][i]).norm());
    }
    for (const double end : {-0.15, 0.15}) {
      const Vec3 at(0, end, 0);
      most = std::max(most, (p.bodies[0].to_world(at) - q.bodies[0].to_world(at)).norm());
    }
  }
  return most;
}

TEST(BodiesAsLinks, AStickIsExactlyALink) {
  for (const bool reversed : {false, true}) {
    EXPECT_LT(apart(hung(solid_cylinder(0.2, 0.3, 0.02), reversed)), 1e-6) << reversed;
  }
}

TEST(BodiesAsLinks, ABoardIsNotQuite) {
  const double board = apart(hung(solid_box(0.2, {0.2, 0.3, 0.01}), false));
  EXPECT_GT(board, 1e-3) << "its moments across the line differ";
  EXPECT_LT(board, 0.2);
}

TEST(BodiesAsLinks, EnergyIsThatOfTheBody) {
  const World rigid = hung(solid_cylinder(0.2, 0.3, 0.02), false);
  World linked = rigid;
  linked.bodies[0].model = BodyModel::link;
  const Simulation simulation(linked, make_method("direct", {}));
  // A thin line has no spin about itself; here there is none.
  EXPECT_NEAR(kinetic_energy(simulation.world()), kinetic_energy(rigid), 1e-12);
  EXPECT_NEAR(potential_energy(simulation.world()), potential_energy(rigid), 1e-12);
}

TEST(BodiesAsLinks, KeepTheBodysAttitude) {
  World world = hung(solid_cylinder(0.2, 0.3, 0.02), false);
  world.bodies[0].model = BodyModel::link;
  const Simulation simulation(world, make_method("direct", {}));
  const Snapshot start = simulation.state(), rigid = snapshot(world);
  EXPECT_LT((start.bodies[0].position - rigid.bodies[0].position).norm(), 1e-15);
  EXPECT_LT(start.bodies[0].rotation.angularDistance(rigid.bodies[0].rotation), 1e-12);
}

TEST(BodiesAsLinks, SayWhyNot) {
  const World good = hung(solid_cylinder(0.2, 0.3, 0.02), false);
  EXPECT_EQ(why_no_link(good, {}, 0), "");

  World centre = good;
  centre.connectors[0].holds[1].to.point = Vec3::Zero();
  EXPECT_EQ(why_no_link(centre, {}, 0), "held by its centre of mass");
  World loop = good;
  loop.connectors[0].holds[0].to = on_body(0, {0, -0.15, 0});
  EXPECT_EQ(why_no_link(loop, {}, 0), "held by more than one point");
  World span = good;
  span.connectors[0].model = ConnectorModel::span;
  EXPECT_EQ(why_no_link(span, {}, 0), "on a massless span");
  World loose = good;
  loose.connectors[0].holds.pop_back();
  EXPECT_EQ(why_no_link(loose, {}, 0), "nothing holds it");
  Timeline pinned;
  pinned.pins.emplace_back().along = 0.1;
  EXPECT_EQ(why_no_link(good, pinned, 0), "on a connector that is pinned or cut");
}

}  // namespace
}  // namespace taut::bodies_as_links_test
