// Pulleys: rope that passes from one connector into another, against known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "../material/material_worlds.h"
#include "../worlds.h"
#include "pulley_worlds.h"
#include "sim/measure/measure.h"
#include "sim/world/connector.h"
#include "sim/world/winched.h"

namespace taut::pulley_test {
namespace {

using material_worlds::after;
using material_worlds::apart;
using pulley_worlds::atwood;
using worlds::kGravity;

// A heavy rope that hangs straight: M q'' = (m2 - m1 + 2 density (q + (b - a)/2)) g.
TEST(Pulley, HeavyRopeRunsAway) {
  for (const std::size_t links : {1u, 2u, 7u}) {
    const World start = atwood({.left = 1, .right = 1, .density = 0.6, .links = links});
    World pushed = start;
    pulley_worlds::set_passing(pushed, 0.1);
    const double rate = std::sqrt(2 * 0.6 * kGravity / (2 + 0.6 * 2));
    const World end = after(pushed, 0.6, "direct", {{"tolerance", 1e-9}});
    EXPECT_NEAR(end.pulleys[0].passed, 0.1 / rate * std::sinh(rate * 0.6), 1e-8) << links;
    EXPECT_NEAR(energy(end), energy(pushed), 1e-8 * energy_scale(pushed)) << links;
  }
}

/// A heavy rope over an eye that swings on one side, and turns about it.
World swinging(std::size_t links, double density = 0.4) {
  World world = atwood({.left_mass = 0.6,
                        .right_mass = 0.5,
                        .degrees = 70,
                        .density = density,
                        .inertia = 0.1,
                        .links = links});
  Connector& rope = world.connectors[1];
  for (std::size_t i = 0; i < rope.particles(); ++i) {
    rope.velocity[i] = 2 * rope.position[i].norm() * Vec3::UnitZ();
  }
  return world;
}

/// The swinging rope whose eye is driven.
World carried() {
  World world = swinging(5);
  std::vector<PathKey> way(2);
  way[0].ease = way[1].ease = true;
  way[1].time = 0.8;
  way[1].position = Vec3(0.4, 0.1, -0.3);
  const auto path = std::make_shared<const Path>(std::move(way));
  world.connectors[0].holds[0].to = world.connectors[1].holds[0].to = worlds::on_path(path);
  refresh(world);
  return world;
}

/// A rope with masses at its ends that runs through an eye of a box, all of which turn in space.
World in_space() {
  World world = swinging(5);
  world.gravity.setZero();
  Body box = worlds::box("box");
  const Vec3 eye(0.02, 0.1, 0.03);
  box.position = -eye;
  box.velocity = -box.spin.cross(eye);
  world.bodies = {box};
  for (Connector& rope : world.connectors) {
    rope.holds[0].to = worlds::on_body(0, eye);
    rope.winch = nullptr;
  }
  world.pulleys.clear();
  for (Connector& rope : world.connectors) {  // equal particles again
    const double half = rope.mass / static_cast<double>(rope.links()) / 2;
    for (std::size_t k = 0; k < rope.links(); ++k) {
      rope.particle_mass[k] -= half;
      rope.particle_mass[k + 1] -= half;
    }
    for (double& mass : rope.particle_mass) {
      mass += rope.mass / static_cast<double>(rope.particles());
    }
  }
  add_pulley(world, "eye", 0, 1, 0.1);
  finish(world);
  return world;
}

/// A rope that falls over two eyes, one lower than the other.
World stairs() {
  World world;
  const Vec3 upper(0, 0, 0), lower(0.3, -0.4, 0);
  Connector from = straight_connector("rope", 0.8, 0.32, 4, Vec3(0, -0.8, 0), Vec3::UnitY());
  Connector between = straight_connector("rope#2", 0.5, 0.2, 3, upper, lower - upper);
  Connector to = straight_connector("rope#3", 0.6, 0.24, 5, lower, worlds::from_down(50));
  from.holds = {{3, worlds::fixed_at(upper)}};
  between.holds = {{0, worlds::fixed_at(upper)}, {2, worlds::fixed_at(lower)}};
  to.holds = {{0, worlds::fixed_at(lower)}};
  from.particle_mass.front() += 0.2;
  to.particle_mass.back() += 0.4;
  world.connectors = {from, between, to};
  add_pulley(world, "upper", 0, 1, 0.05);
  add_pulley(world, "lower", 1, 2, 0.0);
  finish(world);
  return world;
}

TEST(Pulley, RopeKeepsItsLengthAndItsEnergy) {
  for (const World& world : {swinging(1, 0), swinging(4), swinging(12), in_space(), stairs()}) {
    const World start = after(world, 1e-6, 1e-9), end = after(world, 0.6, 1e-9);
    EXPECT_GT(std::abs(end.pulleys[0].passed), 0.02);
    double longer = 0, heavier = 0;
    for (std::size_t c = 0; c < world.connectors.size(); ++c) {
      longer += end.connectors[c].length - world.connectors[c].length;
      heavier += end.connectors[c].mass - world.connectors[c].mass;
    }
    EXPECT_NEAR(longer, 0, 1e-13);
    EXPECT_NEAR(heavier, 0, 1e-13);
    EXPECT_LT(stretch_max(end), 1e-12);
    EXPECT_NEAR(energy(end), energy(start), 1e-8 * energy_scale(start));
  }
}

TEST(Pulley, WhatTurnsInSpaceKeepsItsMomenta) {
  const World start = after(in_space(), 1e-6, 1e-9), end = after(in_space(), 1.0, 1e-9);
  EXPECT_GT(std::abs(end.pulleys[0].passed), 0.02);
  EXPECT_LT((linear_momentum(end) - linear_momentum(start)).norm(), 1e-10);
  EXPECT_LT((angular_momentum(end, Vec3::Zero()) - angular_momentum(start, Vec3::Zero())).norm(),
            1e-8);
}

TEST(Pulley, DirectKeepsToItsTolerance) {
  for (const World& world : {swinging(1, 0), swinging(6), carried(), in_space(), stairs()}) {
    const World truth = after(world, 0.6, "truth", {});
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      EXPECT_LT(apart(after(world, 0.6, tolerance), truth), tolerance) << tolerance;
    }
  }
}

// The middle of the swinging side comes nearer with the square of the links' length.
TEST(Pulley, MoreParticlesComeNearToARope) {
  const auto passed = [](std::size_t links) {
    return after(swinging(links), 0.4, 1e-8).pulleys[0].passed;
  };
  const double coarse = passed(6), middle = passed(12), fine = passed(24);
  EXPECT_NEAR((coarse - middle) / (middle - fine), 4, 0.8);
}

TEST(Pulley, RopeThatHasRunThroughIsTold) {
  const World start = atwood({.left_mass = 1, .right_mass = 2});
  for (const char* method : {"truth", "direct"}) {
    try {
      after(start, 2, method, {});
      ADD_FAILURE() << method;
    } catch (const Diverged& told) {
      EXPECT_EQ(told.connector, "left") << method;
      EXPECT_NEAR(told.time, std::sqrt(2 * 0.792 / (kGravity / 3)), 0.01) << method;
      EXPECT_NE(std::string(told.what()).find("has run through its pulley"), std::string::npos)
          << told.what();
    }
  }
}

/// A tackle: `falls` of massless rope between eyes of the crown and of a block of `load` (kg), from
/// the crown on; then over `lead` fixed eyes, and down to a counterweight.
World tackle(std::size_t falls, std::size_t lead, double load, double counterweight, double inertia,
             double apart) {
  World world;
  Body block;
  block.name = "block";
  block.mass_properties = solid_box(load, Vec3(0.3, 0.2, 0.1));
  block.position = Vec3(0, -1, 0);
  world.bodies = {block};
  const auto aside = [&](std::size_t i) {
    return apart * (static_cast<double>(i) - static_cast<double>(falls) / 2 + 0.5);
  };
  const auto crown = [&](std::size_t i) { return worlds::fixed_at(Vec3(aside(i), 0, 0)); };
  const auto add = [&](const Vec3& from, const Vec3& to, const Attachment& held_from,
                       std::optional<Attachment> held_to) {
    Connector rope = straight_connector("rope", (to - from).norm(), 0, 2, from, to - from);
    rope.holds = {{0, held_from}};
    if (held_to) rope.holds.push_back({1, *held_to});
    world.connectors.push_back(std::move(rope));
  };
  for (std::size_t i = 0; i < falls; ++i) {
    const Vec3 up(aside(i), 0, 0), down(aside(i), -1, 0);
    // A fall begins where the one before it ends.
    const std::size_t before = i == 0 ? 0 : i - 1;
    const Vec3 last(aside(before), i % 2 == 0 ? 0 : -1, 0);
    const Attachment bottom = worlds::on_body(0, Vec3(aside(i), 0, 0));
    const Attachment from = i == 0       ? crown(0)
                            : i % 2 == 0 ? crown(before)
                                         : worlds::on_body(0, Vec3(aside(before), 0, 0));
    i % 2 == 0 ? add(last, down, from, bottom) : add(last, up, from, crown(i));
  }
  Vec3 eye(aside(falls - 1), 0, 0);
  for (std::size_t i = 0; i < lead; ++i) {
    const Vec3 next = eye + Vec3(0.2, 0.1, 0);
    add(eye, next, worlds::fixed_at(eye), worlds::fixed_at(next));
    eye = next;
  }
  add(eye, eye - Vec3(0, 1, 0), worlds::fixed_at(eye), {});
  world.connectors.back().particle_mass.back() = counterweight;
  for (std::size_t c = 0; c + 1 < world.connectors.size(); ++c) {
    add_pulley(world, "sheave", c, c + 1, inertia);
  }
  finish(world);
  return world;
}

// Virtual work: the counterweight and the last sheaves move by `falls` times what the load does,
// the sheaves of the tackle by 1, 2, ... times.
TEST(Pulley, TackleMovesByVirtualWork) {
  for (const double inertia : {0.0, 0.02}) {
    const double load = 60, counterweight = 4;
    const World start = tackle(12, 4, load, counterweight, inertia, 0);
    ASSERT_EQ(start.pulleys.size(), 16u);
    const double acceleration = (load - 12 * counterweight) * kGravity /
                                (load + 144 * counterweight + inertia * (650 + 4 * 144));
    for (const char* method : {"truth", "direct"}) {
      const World end = after(start, 0.5, method, {});
      EXPECT_NEAR(end.bodies[0].position.y(), -1 - acceleration * 0.125, 1e-9) << method;
      EXPECT_NEAR(end.pulleys[15].passed, -12 * acceleration * 0.125, 1e-8) << method;
    }
  }
}

/// With a floor that nothing reaches: the implicit step follows it.
World over_a_floor(World world) {
  Obstacle& floor = world.obstacles.emplace_back();
  floor.name = "floor";
  floor.place.position.y() = -10;
  for (Connector& rope : world.connectors) rope.radius = 0.01;
  refresh(world);
  return world;
}

TEST(Pulley, RopePassesBesideObstaclesAsWithoutThem) {
  World slides = swinging(6);
  slides.pulleys[0].friction = 0.05;
  World stays = swinging(1, 0);
  stays.pulleys[0].bearing = 0.9;
  const World worlds[] = {swinging(1, 0), swinging(6), carried(), in_space(),
                          stairs(),       slides,      stays};
  for (std::size_t i = 0; i < std::size(worlds); ++i) {
    SCOPED_TRACE(i);
    const World& world = worlds[i];
    const World known = after(world, 0.6, 1e-9);
    for (const double tolerance : {1e-3, 1e-5}) {
      const World end = after(over_a_floor(world), 0.6, tolerance);
      EXPECT_LT(apart(end, known), tolerance);
      EXPECT_NEAR(end.pulleys[0].passed, known.pulleys[0].passed, 2 * tolerance);
    }
  }
}

TEST(Pulley, RopeThatHasRunThroughIsToldBesideObstacles) {
  try {
    after(over_a_floor(atwood({.left_mass = 1, .right_mass = 2})), 2, "direct", {});
    ADD_FAILURE();
  } catch (const Diverged& told) {
    EXPECT_EQ(told.connector, "left");
    EXPECT_NEAR(told.time, std::sqrt(2 * 0.792 / (kGravity / 3)), 0.01);
    EXPECT_NE(std::string(told.what()).find("has run through its pulley"), std::string::npos)
        << told.what();
  }
}

// A rope on a table is drawn over its edge by a weight: M q'' = (m + density x) g - friction
// density y g, of x that hang and y that lie. The half of a link at the eye is not on the table.
TEST(Pulley, RopeSlidesOffATable) {
  constexpr double kFriction = 0.3, kDensity = 0.5, kLies = 1.0, kHangs = 0.4, kWeight = 0.3;
  for (const std::size_t links : {2u, 6u}) {
    World world;
    const double radius = 0.01;
    const Vec3 edge(0, radius, 0);
    Connector lies = straight_connector("lies", kLies, kDensity * kLies, links + 1,
                                        Vec3(-kLies, radius, 0), Vec3::UnitX());
    Connector hangs =
        straight_connector("hangs", kHangs, kDensity * kHangs, links + 1, edge, -Vec3::UnitY());
    lies.holds = {{links, worlds::fixed_at(edge)}};
    hangs.holds = {{0, worlds::fixed_at(edge)}};
    hangs.particle_mass.back() += kWeight;
    lies.radius = hangs.radius = radius;
    world.connectors = {lies, hangs};
    add_pulley(world, "edge", 0, 1, 0);
    Obstacle& table = world.obstacles.emplace_back();
    table.name = "table";
    table.shape = box_shape(Vec3(2, 1, 1));
    table.place.position = Vec3(-1.02, -0.5, 0);
    table.static_friction = table.kinetic_friction = kFriction;
    finish(world);
    const double mass = kWeight + kDensity * (kLies + kHangs);
    const double drag = kFriction * (1 - 0.5 / static_cast<double>(links));
    const double square = kDensity * kGravity * (1 + drag) / mass;
    const double first = kGravity * (kWeight + kDensity * (kHangs - drag * kLies)) / mass;
    const World end = after(world, 0.5, 1e-6);
    const double known = first / square * (std::cosh(std::sqrt(square) * 0.5) - 1);
    EXPECT_NEAR(end.pulleys[0].passed, known, 1e-6);
    EXPECT_NEAR(end.connectors[0].position[0].x(), -kLies + known, 1e-6);
    EXPECT_GT(known, 0.3);
  }
}

/// A rope over an eye, or two, that stretches.
World elastic(World world, double stiffness) {
  Section section;
  section.axial_stiffness = stiffness;
  for (Connector& rope : world.connectors) rope.sections.assign(rope.links(), section);
  refresh(world);
  return world;
}

TEST(Pulley, RopeThatStretchesKeepsItsEnergyAndMomenta) {
  for (const World& world : {swinging(1, 0), swinging(4), in_space(), stairs()}) {
    const World start = elastic(world, 300), end = after(start, 0.5, 1e-6);
    EXPECT_GT(std::abs(end.pulleys[0].passed), 0.02);
    EXPECT_GT(stretch_max(end), 1e-3);
    EXPECT_NEAR(energy(end), energy(start), 1e-5 * energy_scale(start));
    if (!world.gravity.isZero()) continue;
    EXPECT_LT((linear_momentum(end) - linear_momentum(start)).norm(), 1e-6);
    const Vec3 about = Vec3::Zero();
    EXPECT_LT((angular_momentum(end, about) - angular_momentum(start, about)).norm(), 1e-6);
  }
}

TEST(Pulley, StifferRopesComeNearToRigidOnes) {
  const World rigid = after(swinging(4), 0.5, 1e-7);
  double before = 1;
  for (const double stiffness : {3e3, 3e4, 3e5}) {
    const double now = apart(after(elastic(swinging(4), stiffness), 0.5, 1e-5), rigid);
    EXPECT_LT(now, before / 5) << stiffness;
    before = now;
  }
}

}  // namespace
}  // namespace taut::pulley_test
