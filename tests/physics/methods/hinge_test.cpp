// Connectors of length 0: rings and hinges, by each method that follows them, against truth.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::hinge_test {
namespace {

/// A rod of 1 m and 1 kg, which stands on its centre of mass at `at`, along y or `across`.
Body rod(const std::string& name, const Vec3& at, bool across = false) {
  Body made;
  made.name = name;
  made.mass_properties.mass = 1;
  made.mass_properties.inertia =
      Vec3(across ? 1e-3 : 1.0 / 12, across ? 1.0 / 12 : 1e-3, 1.0 / 12).asDiagonal();
  made.position = at;
  return made;
}

Connector hinge(const std::string& name, const Vec3& at, const Attachment& from,
                const Attachment& to) {
  Connector made = straight_connector(name, 0, 0, 2, at, Vec3::UnitY());
  made.holds = {{0, from}, {1, to}};
  return made;
}

/// `count` rods below each other, from a fixed point; the last is struck.
World hanging_rods(std::size_t count) {
  World world;
  for (std::size_t k = 0; k < count; ++k) {
    const double top = -static_cast<double>(k);
    world.bodies.push_back(rod("rod" + std::to_string(k), Vec3(0, top - 0.5, 0)));
    const Attachment above =
        k == 0 ? worlds::fixed_at(Vec3::Zero()) : worlds::on_body(k - 1, Vec3(0, -0.5, 0));
    world.connectors.push_back(hinge("hinge" + std::to_string(k), Vec3(0, top, 0), above,
                                     worlds::on_body(k, Vec3(0, 0.5, 0))));
  }
  world.bodies.back().velocity = Vec3(1, 0, 0.3);
  world.bodies.back().spin = Vec3(-0.6, 0, 2);
  finish(world);
  return world;
}

/// Two rods that hang, and one that joins their lower ends: one condition too many in space.
World four_bar() {
  World world;
  world.bodies = {rod("left", Vec3(0, -0.5, 0)), rod("right", Vec3(1, -0.5, 0)),
                  rod("lower", Vec3(0.5, -1, 0), true)};
  for (std::size_t k : {0u, 1u}) {
    world.bodies[k].velocity = Vec3(0.5, 0, 0);
    world.bodies[k].spin = Vec3(0, 0, 1);
    const Vec3 top(k == 0 ? 0 : 1, 0, 0);
    world.connectors.push_back(
        hinge(k == 0 ? "a" : "b", top, worlds::fixed_at(top), worlds::on_body(k, Vec3(0, 0.5, 0))));
  }
  world.bodies[2].velocity = Vec3(1, 0, 0);
  world.connectors.push_back(hinge("c", Vec3(0, -1, 0), worlds::on_body(0, Vec3(0, -0.5, 0)),
                                   worlds::on_body(2, Vec3(-0.5, 0, 0))));
  world.connectors.push_back(hinge("d", Vec3(1, -1, 0), worlds::on_body(2, Vec3(0.5, 0, 0)),
                                   worlds::on_body(1, Vec3(0, -0.5, 0))));
  finish(world);
  return world;
}

World after(const World& start, const char* method, const Settings& settings, double time = 0.4) {
  Simulation simulation(start, make_method(method, settings));
  const int frames = static_cast<int>(std::lround(50 * time));
  for (int k = 1; k <= frames; ++k) simulation.advance_to(k / 50.0);
  return std::as_const(simulation).world();
}

double apart(const World& a, const World& b) {
  double most = 0;
  for (std::size_t k = 0; k < a.bodies.size(); ++k) {
    most = std::max(most, (a.bodies[k].position - b.bodies[k].position).norm());
  }
  return most;
}

void expect_as_truth(const World& start, const std::string& what) {
  const World truth = after(start, "truth", {});
  EXPECT_LT(apart(after(start, "direct", {{"tolerance", 1e-6}}), truth), 1e-5) << what;
  EXPECT_LT(apart(after(start, "direct", {{"step", 1.0 / 400}}), truth), 1e-3) << what;
  EXPECT_LT(apart(after(start, "dynamic-constraints", {{"step", 5e-4}}), truth), 5e-3) << what;
  EXPECT_LT(apart(after(start, "xpbd", {{"step", 2.5e-4}}), truth), 5e-2) << what;
}

TEST(Hinge, ChainsOfRodsGoAsTruthSays) {
  for (const std::size_t count : {1u, 2u, 4u}) {
    expect_as_truth(hanging_rods(count), std::to_string(count) + " rods");
  }
}

TEST(Hinge, AFourBarGoesAsTruthSays) {
  expect_as_truth(four_bar(), "four-bar");
}

// Far from an obstacle they go as without one, and near one too.
TEST(Hinge, AnObstacleThatNothingTouchesChangesNothing) {
  for (const double height : {-8.0, -2.6}) {
    World start = hanging_rods(2);
    const World without = after(start, "direct", {{"tolerance", 1e-5}});
    for (Body& body : start.bodies) body.capsule = {0.01, Vec3(0, -0.4, 0), Vec3(0, 0.4, 0)};
    Obstacle floor;
    floor.name = "floor";
    floor.shape = plane_shape();
    floor.place.position = Vec3(0, height, 0);
    start.obstacles = {floor};
    start.topology = 0;
    for (Body& body : start.bodies) body.mass_properties = body.bare;
    finish(start);
    EXPECT_LT(apart(after(start, "direct", {{"tolerance", 1e-5}}), without), 1e-3) << height;
  }
}

// Links of a trillionth of a metre are no scale for errors either.
TEST(Hinge, AShortestLinkIsNearlyOne) {
  World start = hanging_rods(2);
  World near = start;
  for (Connector& connector : near.connectors) {
    connector.length = connector.rest[0] = 1e-9;
    connector.position[1] = connector.position[0] - Vec3(0, 1e-9, 0);
  }
  for (std::size_t k = 0; k < near.bodies.size(); ++k) {
    near.bodies[k].position.y() -= 1e-9 * static_cast<double>(k + 1);
    near.bodies[k].mass_properties = near.bodies[k].bare;
  }
  near.topology = 0;
  finish(near);
  const World a = after(start, "direct", {{"tolerance", 1e-5}}, 0.2);
  try {
    EXPECT_LT(apart(after(near, "direct", {{"tolerance", 1e-5}}, 0.2), a), 1e-4);
  } catch (const Diverged& error) {  // or it says so
    EXPECT_NE(std::string(error.what()).find("hinge"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace taut::hinge_test
