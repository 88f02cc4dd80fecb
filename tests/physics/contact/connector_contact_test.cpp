// Connectors that touch each other and themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/contact/capsule.h"
#include "sim/interventions/interventions.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/world/world.h"
#include "tests/physics/worlds.h"

namespace taut::connector_contact_test {
namespace {

constexpr double kRadius = 0.01;  // m

Connector& add_rod(World& world, const char* name, const Vec3& from, const Vec3& to, double mass,
                   double radius = kRadius) {
  world.connectors.push_back(
      straight_connector(name, (to - from).norm(), mass, 2, from, (to - from).normalized()));
  world.connectors.back().radius = radius;
  return world.connectors.back();
}

void hold_both_ends(Connector& rod) {
  rod.holds = {{0, worlds::fixed_at(rod.position[0])}, {1, worlds::fixed_at(rod.position[1])}};
}

void give(Connector& rod, const Vec3& velocity) {
  for (Vec3& own : rod.velocity) own = velocity;
}

World run(const World& world, double until, double tolerance = 1e-5) {
  Simulation simulation(world, make_method("direct", {{"tolerance", tolerance}}));
  simulation.advance_to(until);
  return simulation.world();
}

Vec3 middle(const Connector& rod) {
  return (rod.position[0] + rod.position[1]) / 2;
}

/// A bar that is let go across a beam with a slope of 30 degrees, held at both ends.
World bar_across_a_beam(double friction) {
  constexpr double kThick = 0.05;
  const Vec3 down(std::cos(M_PI / 6), -std::sin(M_PI / 6), 0);
  const Vec3 at = (kThick + kRadius) * Vec3(std::sin(M_PI / 6), std::cos(M_PI / 6), 0);
  World world;
  hold_both_ends(add_rod(world, "beam", -down, 2 * down, 1, kThick));
  add_rod(world, "bar", at - 0.2 * Vec3::UnitZ(), at + 0.2 * Vec3::UnitZ(), 0.1);
  world.connector_pairs = {{0, 1, friction, friction, 0}};
  finish(world);
  return world;
}

/// m, of the bar after `time` (s) from where a block on a slope would be.
double off_the_slope(const World& start, const World& end, double friction, double time) {
  const double pull = std::sin(M_PI / 6) - friction * std::cos(M_PI / 6);
  const double slides = std::max(worlds::kGravity * pull, 0.0) * time * time / 2;
  const Vec3 down(std::cos(M_PI / 6), -std::sin(M_PI / 6), 0);
  return (middle(end.connectors[1]) - middle(start.connectors[1]) - slides * down).norm();
}

TEST(ConnectorContact, RodsThatMeetInTheMiddleDivideTheSpeedByNewtonsLaw) {
  for (const double restitution : {0.0, 0.6, 1.0}) {
    World world;
    world.gravity.setZero();
    give(add_rod(world, "a", Vec3(-0.5, -0.1, 0), Vec3(0.5, -0.1, 0), 1), Vec3::UnitY());
    add_rod(world, "b", Vec3(0, 0.1, -0.5), Vec3(0, 0.1, 0.5), 1);
    world.connector_pairs = {{0, 1, 0.5, 0.5, restitution}};
    finish(world);
    const World end = run(world, 0.5);
    for (int i : {0, 1}) {
      EXPECT_NEAR(end.connectors[0].velocity[i].y(), (1 - restitution) / 2, 1e-9) << restitution;
      EXPECT_NEAR(end.connectors[1].velocity[i].y(), (1 + restitution) / 2, 1e-9) << restitution;
    }
  }
}

TEST(ConnectorContact, RodsThatMeetAsideKeepBothMomentaAndWithoutLossTheEnergy) {
  World world;
  world.gravity.setZero();
  give(add_rod(world, "a", Vec3(-0.3, -0.1, 0.02), Vec3(0.7, -0.13, 0.1), 1), Vec3(0.1, 2, 0));
  give(add_rod(world, "b", Vec3(0.02, 0.1, -0.3), Vec3(0.2, 0.05, 0.7), 0.4), Vec3(0, -1, 0.2));
  world.connector_pairs = {{0, 1, 0, 0, 1}};
  finish(world);
  const World end = run(world, 0.3);
  EXPECT_LT((linear_momentum(end) - linear_momentum(world)).norm(), 1e-9);
  EXPECT_LT((angular_momentum(end) - angular_momentum(world)).norm(), 1e-7);
  EXPECT_NEAR(energy(end), energy(world), 1e-7);
  EXPECT_GT((end.connectors[0].velocity[0] - world.connectors[0].velocity[0]).norm(), 0.5);
}

TEST(ConnectorContact, AHeldRodIsAPost) {
  constexpr double kPost = 0.03;
  for (const double friction : {0.0, 0.4}) {
    World world;
    Connector rope =
        straight_connector("rope", 1, 0.1, 21, Vec3(-0.37, kPost + kRadius, 0), Vec3::UnitX());
    rope.radius = kRadius;
    World other = world;
    world.connectors = other.connectors = {rope};
    hold_both_ends(add_rod(world, "post", Vec3(0, 0, -0.5), Vec3(0, 0, 0.5), 1, kPost));
    world.connector_pairs = {{0, 1, friction, friction, 0}};
    finish(world);
    other.connectors[0].links_touch = true;
    Obstacle post;
    post.name = "post";
    post.shape = capsule_shape(kPost, 1);
    post.place.rotation = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
    post.static_friction = post.kinetic_friction = friction;
    other.obstacles = {post};
    finish(other);
    const World by_rod = run(world, 0.4, 1e-4), by_post = run(other, 0.4, 1e-4);
    double sum = 0;
    for (std::size_t i = 0; i < 21; ++i) {
      sum += (by_rod.connectors[0].position[i] - by_post.connectors[0].position[i]).squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / 21), 2e-4) << friction;
    EXPECT_LT(by_rod.connectors[0].position[20].y(), -0.2);  // it has fallen over the post
  }
}

/// A closed chain of 12 rods in a plane.
void add_ring(World& world, const char* name, const Vec3& centre, const Vec3& x, const Vec3& y) {
  constexpr std::size_t kLinks = 12;
  constexpr double kSize = 0.1;  // m
  Connector ring = straight_connector(name, 2 * kSize * kLinks * std::sin(M_PI / kLinks), 0.1,
                                      kLinks + 1, Vec3::Zero(), Vec3::UnitX());
  for (std::size_t i = 0; i <= kLinks; ++i) {
    const double angle = 2 * M_PI * double(i % kLinks) / kLinks;
    ring.position[i] = centre + kSize * (std::cos(angle) * x + std::sin(angle) * y);
  }
  ring.radius = 0.005;
  const std::size_t index = world.connectors.size();
  world.connectors.push_back(ring);
  world.joints.push_back({{{index, 0}, {index, kLinks}}});
}

World linked_rings() {
  World world;
  world.gravity.setZero();
  add_ring(world, "a", Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
  add_ring(world, "b", Vec3(0.1, 0.013, 0.007), Vec3::UnitX(), Vec3::UnitZ());
  world.connector_pairs = {{0, 1, 0.2, 0.2, 0.3}};
  finish(world);
  return world;
}

TEST(ConnectorContact, LinkedRingsStayLinkedHoweverFastTheyAreThrown) {
  for (const double speed : {1.0, 30.0, 300.0}) {
    for (const Settings& settings : {Settings{{"tolerance", 1e-2}}, {{"step", 1e-3}}}) {
      World world = linked_rings();
      give(world.connectors[1], speed * Vec3(1, 0.2, 0.1));
      ASSERT_EQ(std::abs(linking_number(curve_of(world, 0), curve_of(world, 1))), 1);
      Simulation simulation(world, make_method("direct", settings));
      for (int i = 1; i <= 10; ++i) {
        simulation.advance_to(0.05 * i / std::sqrt(speed));
        const World& now = simulation.world();
        EXPECT_EQ(std::abs(linking_number(curve_of(now, 0), curve_of(now, 1))), 1) << speed;
        EXPECT_LT(contact::penetration_max(now), 1e-5) << speed;
      }
    }
  }
}

class ConnectorContactInGames : public testing::TestWithParam<const char*> {};

TEST_P(ConnectorContactInGames, ABarSlidesDownABeamAsOnASlope) {
  constexpr double kTime = 0.4;
  for (const double friction : {0.0, 0.3, 0.7}) {
    const World world = bar_across_a_beam(friction);
    Simulation simulation(world, make_method(GetParam(), {{"step", 1e-4}}));
    simulation.advance_to(kTime);
    EXPECT_LT(off_the_slope(world, simulation.world(), friction, kTime), 2e-3) << friction;
  }
}

TEST_P(ConnectorContactInGames, RodsThatMeetInTheMiddleDivideTheSpeedByNewtonsLaw) {
  for (const double restitution : {0.0, 0.6, 1.0}) {
    World world;
    world.gravity.setZero();
    give(add_rod(world, "a", Vec3(-0.5, -0.1, 0), Vec3(0.5, -0.1, 0), 1), Vec3::UnitY());
    add_rod(world, "b", Vec3(0, 0.1, -0.5), Vec3(0, 0.1, 0.5), 1);
    world.connector_pairs = {{0, 1, 0.5, 0.5, restitution}};
    finish(world);
    Simulation simulation(world, make_method(GetParam(), {{"step", 1e-4}}));
    simulation.advance_to(0.5);
    const World& end = simulation.world();
    EXPECT_NEAR(end.connectors[0].velocity[0].y(), (1 - restitution) / 2, 1e-6) << restitution;
    EXPECT_NEAR(end.connectors[1].velocity[0].y(), (1 + restitution) / 2, 1e-6) << restitution;
  }
}

TEST_P(ConnectorContactInGames, LinkedRingsStayLinked) {
  World world = linked_rings();
  give(world.connectors[1], 5 * Vec3(1, 0.2, 0.1));
  Simulation simulation(world, make_method(GetParam(), {{"step", 1e-4}}));
  for (int i = 1; i <= 10; ++i) {
    simulation.advance_to(0.02 * i);
    const World& now = simulation.world();
    EXPECT_EQ(std::abs(linking_number(curve_of(now, 0), curve_of(now, 1))), 1) << i;
    EXPECT_LT((linear_momentum(now) - linear_momentum(world)).norm(), 1e-9) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, ConnectorContactInGames, testing::Values("xpbd", "springs"));

TEST(ConnectorContact, AChainOnItselfKeepsItsMomentaAndDoesNotPass) {
  World world;
  world.gravity.setZero();
  Connector chain = straight_connector("chain", 1, 0.1, 21, Vec3::Zero(), Vec3::UnitX());
  chain.radius = kRadius;
  for (std::size_t i = 0; i < 21; ++i) {  // its ends fly together, crosswise
    chain.velocity[i] =
        (i < 10 ? 1.0 : -1.0) * Vec3(0.3, 1.0 - 0.1 * std::abs(10.0 - double(i)), 0);
    if (i > 10) chain.velocity[i] += Vec3(0, 0, 0.2);
  }
  world.connectors = {chain};
  world.connector_pairs = {{0, 0, 0.3, 0.3, 0}};
  finish(world);
  Simulation simulation(world, make_method("direct", {{"tolerance", 1e-4}}));
  simulation.advance_to(0);
  const Vec3 linear = linear_momentum(simulation.world());
  const Vec3 angular = angular_momentum(simulation.world());
  double before = energy(simulation.world());
  for (int i = 1; i <= 20; ++i) {
    simulation.advance_to(0.05 * i);
    const World& now = simulation.world();
    EXPECT_LT(contact::penetration_max(now), 1e-6) << i;
    EXPECT_LT((linear_momentum(now) - linear).norm(), 1e-6) << i;
    EXPECT_LT((angular_momentum(now) - angular).norm(), 1e-4) << i;
    EXPECT_LT(energy(now), before + 1e-6) << i;
    before = energy(now);
  }
}

TEST(ConnectorContact, LinksThatAreNearAlongTheRopeDoNotTouch) {
  World world;
  Connector rope = straight_connector("rope", 1, 0.1, 21, Vec3::Zero(), Vec3::UnitX());  // 5 cm
  rope.radius = 0.03;  // half a circle of it: 9.4 cm, less than two links
  world.connectors = {rope};
  world.connector_pairs = {{0, 0, 0, 0, 0}};
  finish(world);
  contact::NearLinks near;
  near.rebuild(world);
  std::vector<contact::LinkPair> pairs;
  near.find({world.connectors[0].position.data()->data(), 63}, 1, pairs);
  EXPECT_EQ(pairs.size(), 20u * 19 / 2 - 19 - 18);  // but neighbours and those one link apart
  for (const contact::LinkPair& pair : pairs) EXPECT_GE(pair.b, pair.a + 3);
}

TEST(ConnectorContact, WhatIsCutOffTouchesAsBefore) {
  World world;
  for (const char* name : {"rope", "other"}) {
    world.connectors.push_back(straight_connector(name, 1, 0.1, 21, Vec3::Zero(), Vec3::UnitX()));
    world.connectors.back().radius = kRadius;
  }
  for (Vec3& at : world.connectors[1].position) at.y() += 1;
  world.connector_pairs = {{0, 0, 0.1, 0.1, 0}, {0, 1, 0.2, 0.2, 0}};
  finish(world);
  Timeline timeline;
  timeline.cuts.push_back({.connector = 0, .along = 0.52, .time = 0.1});
  Simulation simulation(world, make_method("direct", {}), timeline);
  simulation.advance_to(0.2);
  const auto& pairs = simulation.world().connector_pairs;
  const auto has = [&](std::size_t a, std::size_t b, double friction) {
    return std::ranges::any_of(pairs, [&](const ConnectorPair& pair) {
      return std::minmax(pair.a, pair.b) == std::minmax(a, b) && pair.kinetic_friction == friction;
    });
  };
  EXPECT_EQ(pairs.size(), 5u);
  EXPECT_TRUE(has(0, 0, 0.1) && has(0, 2, 0.1) && has(2, 2, 0.1) && has(0, 1, 0.2) &&
              has(1, 2, 0.2));
}

// A rope is thrown up its own line and cut. A second cut divides the world anew: the ends of the
// first, which lie in each other, are near along rope as before.
TEST(ConnectorContact, EndsThatWereCutFromEachOtherStayNear) {
  World world;
  Connector rope = straight_connector("rope", 0.4, 0.1, 11, Vec3::Zero(), Vec3::UnitY());
  rope.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  rope.radius = kRadius;
  world.connectors = {rope};
  world.connector_pairs = {{0, 0, 0.1, 0.1, 0}};
  finish(world);
  Timeline timeline;
  timeline.cuts.push_back({.connector = 0, .along = 0.09, .time = 0.01});
  timeline.cuts.push_back({.connector = 0, .along = 0.3, .time = 0.03});
  Simulation simulation(world, make_method("direct", {}), timeline);
  EXPECT_EQ(simulation.world().connectors[0].end_place[0], 1u);
  simulation.advance_to(0.06);
  const auto& parts = simulation.world().connectors;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].end_place[1], parts[1].end_place[0]);
  EXPECT_EQ(parts[1].end_place[1], parts[2].end_place[0]);
  EXPECT_NE(parts[0].end_place[1], parts[1].end_place[1]);
  EXPECT_EQ(parts[2].end_place[1], 2u);
  for (const Connector& part : parts) {
    for (const Vec3& velocity : part.velocity) EXPECT_LT(velocity.norm(), 1);
  }
}

// A hanging rope is cut twice, and its parts fall onto a floor: the last link slides back over the
// links before the cut, which it may not touch, into one that it may. It goes on without a jump.
TEST(ConnectorContact, CutPartsMaySlideIntoEachOtherNearTheCut) {
  for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
    World world;
    Connector rope =
        straight_connector("rope", 0.4, 0.05, 11, Vec3::UnitY(), Vec3(0.3, -1, 0).normalized());
    rope.holds = {{0, worlds::fixed_at(Vec3::UnitY())}};
    rope.radius = 0.004;
    world.connectors = {rope};
    world.connector_pairs = {{0, 0, 0.1, 0.1, 0}};
    Obstacle floor;
    floor.shape = plane_shape();
    floor.place.position = Vec3(0, 0.58, 0);
    floor.static_friction = floor.kinetic_friction = 2;
    world.obstacles = {floor};
    finish(world);
    Timeline timeline;
    timeline.cuts.push_back({.connector = 0, .along = 0.2, .time = 0.1});
    timeline.cuts.push_back({.connector = 0, .along = 0.31, .time = 0.1});
    Simulation simulation(world, make_method("direct", {{"tolerance", tolerance}}), timeline);
    double before = energy(world);
    for (int frame = 1; frame <= 60; ++frame) {
      ASSERT_NO_THROW(simulation.advance_to(frame / 60.0)) << tolerance;
      const double now = energy(simulation.world());
      EXPECT_LT(now, before + tolerance) << tolerance << " at " << frame;
      before = now;
    }
    EXPECT_GT(simulation.world().connectors[2].position[0].y(), 0.58 + 0.004 - tolerance);
  }
}

TEST(Curves, WindAboutEachOtherAndThemselves) {
  const World world = linked_rings();
  const Curve a = curve_of(world, 0), b = curve_of(world, 1);
  EXPECT_TRUE(a.closed);
  EXPECT_EQ(std::abs(linking_number(a, b)), 1);
  EXPECT_EQ(linking_number(a, b), linking_number(b, a));
  Curve away = b;
  for (Vec3& at : away.corners) at.x() += 0.3;
  EXPECT_EQ(linking_number(a, away), 0);
  EXPECT_NEAR(writhe(a), 0, 1e-9);  // it is plane
  // A trefoil on a torus, whose strands cross three times: its writhe tends to 3 as it is flat.
  Curve trefoil{{}, true};
  for (int i = 0; i < 600; ++i) {
    const double t = 2 * M_PI * i / 600, around = 1 + 0.3 * std::cos(3 * t);
    trefoil.corners.emplace_back(around * std::cos(2 * t), around * std::sin(2 * t),
                                 -0.01 * std::sin(3 * t));
  }
  EXPECT_NEAR(std::abs(writhe(trefoil)), 3, 0.1);
  // A line through a ring, closed far away.
  const Curve line{{Vec3(0.01, 0.02, -1), Vec3(0.02, 0, 0.7)}, false};
  EXPECT_EQ(std::abs(linking_number(a, line)), 1);
  const Curve outside{{Vec3(0.3, 0.02, -1), Vec3(0.4, 0, 0.7)}, false};
  EXPECT_EQ(linking_number(a, outside), 0);
}

}  // namespace
}  // namespace taut::connector_contact_test
