// Winches: lengths that change, against known answers, energy, momentum and the truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>

#include "../material/material_worlds.h"
#include "../worlds.h"
#include "sim/links/tension.h"
#include "sim/measure/measure.h"
#include "sim/run/reduced.h"
#include "sim/truth/truth.h"
#include "sim/world/connector.h"
#include "sim/world/winched.h"

namespace taut::winch_test {
namespace {

using material_worlds::after;
using material_worlds::apart;
using worlds::kGravity;

std::shared_ptr<const Path> paying(std::vector<std::pair<double, double>> keys, bool ease = true) {
  std::vector<PathKey> made;
  for (const auto& [time, length] : keys) {
    made.push_back({time, Vec3(length, 0, 0), Quat::Identity(), ease});
  }
  return std::make_shared<const Path>(std::move(made));
}

/// A rope of 0.1 kg with a load of 0.3 kg, held at the origin, that starts `degrees` from down; in
/// a second it is let out by half of its length, and in the next two it is drawn in to a half.
World hoist(std::size_t particles, double degrees) {
  World world = worlds::chain(particles, 1, worlds::from_down(degrees), 0.1);
  Connector& rope = world.connectors[0];
  rope.particle_mass.back() += 0.3;
  add_winches(world, rope, paying({{0, 0}, {1, 0.5}, {3, -0.5}}), nullptr);
  finish(world);
  return world;
}

/// The same in space, where the load flies about the winch.
World whirl(std::size_t particles) {
  World world = hoist(particles, 90);
  world.gravity.setZero();
  Connector& rope = world.connectors[0];
  for (std::size_t i = 0; i < particles; ++i) {
    rope.velocity[i] =
        3 * Vec3::UnitY() * rope.position[i].x() + Vec3::UnitZ() * rope.position[i].x();
  }
  finish(world);
  return world;
}

/// A trolley at the origin that drives off with the winch, and a box that it carries.
World crane(std::size_t particles) {
  World world = worlds::chain_with_box(particles);
  Connector& rope = world.connectors[0];
  std::vector<PathKey> way(2);
  way[0].ease = way[1].ease = true;
  way[1].time = 0.8;
  way[1].position = Vec3(1, 0.1, -0.3);
  rope.holds[0].to = worlds::on_path(std::make_shared<const Path>(std::move(way)));
  add_winches(world, rope, paying({{0, 0}, {0.3, 0.1}, {1, -0.15}}), nullptr);
  world.bodies[0].mass_properties = world.bodies[0].bare;
  finish(world);
  return world;
}

/// A rope that sags between two winches, of which one pays out what the other takes in, and more.
World between_two(std::size_t particles) {
  World world;
  const Vec3 to(0.6, 0.2, 0);
  Connector rope = straight_connector("rope", 1, 0.2, particles, Vec3::Zero(), Vec3::UnitX());
  rope.position = hanging_points(rope, Vec3::Zero(), to, world.gravity);
  rope.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {particles - 1, worlds::fixed_at(to)}};
  add_winches(world, rope, paying({{0, 0}, {1, 0.8}}), paying({{0, 0}, {0.5, -0.1}, {1, -0.5}}));
  world.connectors = {rope};
  finish(world);
  return world;
}

/// A rope in space that runs from one winch to the other at `speed` (m/s).
World running(double speed) {
  World world = between_two(9);
  world.gravity.setZero();
  // Far from its ends a spline through equal steps is straight.
  std::vector<std::pair<double, double>> out, in;
  for (int i = -30; i <= 30; ++i) {
    out.emplace_back(i, speed * i);
    in.emplace_back(i, -speed * i);
  }
  add_winches(world, world.connectors[0], paying(out, false), paying(in, false));
  finish(world);
  return world;
}

/// A hoist whose rope resists bending and is clamped where it comes out.
World stiff(std::size_t particles) {
  World world = hoist(particles, 40);
  Connector& rope = world.connectors[0];
  Section section;
  section.bending_stiffness = 0.05;
  rope.sections.assign(rope.links(), section);
  rope.holds[0].clamp = worlds::from_down(40);
  finish(world);
  return world;
}

struct Case {
  const char* name;
  World world;
};
std::vector<Case> cases() {
  return {{"hoist", hoist(9, 40)},
          {"stiff", stiff(9)},
          {"whirl", whirl(9)},
          {"crane", crane(7)},
          {"between two", between_two(9)}};
}

TEST(Winch, LengthsAreWhatIsPaidOut) {
  for (const Case& each : cases()) {
    const World end = after(each.world, 0.7, 1e-6);
    const Connector& rope = end.connectors[0];
    const double longer = rope.winch->longer(0.7).length;
    EXPECT_GT(std::abs(longer), 0.01) << each.name;
    EXPECT_NEAR(rope.length, each.world.connectors[0].length + longer, 1e-15) << each.name;
    EXPECT_NEAR(rope.mass - each.world.connectors[0].mass, rope.winch->density * longer, 1e-15);
    EXPECT_LT(stretch_max(end), 1e-12) << each.name;
  }
}

// A spline goes below its keys.
TEST(Winch, KnowsTheLeastThatItPaysOut) {
  World world = worlds::chain(5, 1, worlds::from_down(0));
  add_winches(world, world.connectors[0], paying({{0, 0}, {1, -0.5}, {1.3, 3}, {2, 0}}, false),
              nullptr);
  const Winch& winch = *world.connectors[0].winch;
  double sampled = 0;
  for (int i = 0; i <= 2000000; ++i) sampled = std::min(sampled, winch.longer(i * 1e-6).length);
  EXPECT_LT(sampled, -0.5);
  EXPECT_NEAR(winch.least(), sampled, 1e-10);
}

TEST(Winch, DirectKeepsToItsTolerance) {
  for (const Case& each : cases()) {
    const World truth = after(each.world, 0.9, "truth", {});
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      EXPECT_LT(apart(after(each.world, 0.9, tolerance), truth), tolerance)
          << each.name << " " << tolerance;
    }
  }
}

/// The work (J) of the first rope's winch, and the kinetic energy with which rope comes out of it,
/// by Simpson's rule over an even number of intervals (s). A unit of rope of the axial `stiffness`
/// (N) carries the energy T^2 / (2 EA).
double winch_work(Simulation& simulation, int intervals, double interval,
                  double stiffness = std::numeric_limits<double>::infinity()) {
  double work = 0;
  for (int i = 0; i <= intervals; ++i) {
    simulation.advance_to(i * interval);
    const World& now = simulation.world();
    const Winch& winch = *now.connectors[0].winch;
    const double rate = winch.paid_out(0, now.time).rate, pull = winch_tension(now, 0, 0);
    const double carried = pull + pull * pull / (2 * stiffness);
    const double power = (winch.density * rate * rate / 2 - carried) * rate;
    work += power * interval / 3 * (i == 0 || i == intervals ? 1 : i % 2 == 1 ? 4 : 2);
  }
  return work;
}

// Simpson's rule errs by less than 1e-9 J here.
TEST(Winch, WorkIsTheEnergyGained) {
  for (const World& world : {hoist(9, 40), stiff(9)}) {
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-9}}));
    const double work = winch_work(simulation, 1500, 1e-3);
    EXPECT_GT(std::abs(work), 0.1);
    EXPECT_NEAR(energy(simulation.world()) - energy(world), work, 1e-7 * std::abs(work));
  }
}

// No particle enters or leaves, so nothing jumps: second differences of the tension fall with the
// square of the time between them, where a jump would stay.
TEST(Winch, TensionNeverJumps) {
  const World world = hoist(9, 40);
  const auto roughest = [&](double interval) {
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-9}}));
    std::vector<double> tension;
    double most = 0;
    for (int i = 0; i * interval < 0.8; ++i) {  // no key of the path is in there
      simulation.advance_to(0.1 + i * interval);
      tension.push_back(winch_tension(simulation.world(), 0, 0));
      if (i < 2) continue;
      const double* last = &tension.back();
      most = std::max(most, std::abs(last[0] - 2 * last[-1] + last[-2]) / last[0]);
    }
    return most;
  };
  EXPECT_NEAR(std::log2(roughest(2e-3) / roughest(1e-3)), 2, 0.1);
}

// The winch's pull has no moment about the winch, and what comes out of it brings none.
TEST(Winch, WhirlKeepsItsAngularMomentum) {
  const World start = whirl(9), end = after(start, 2.9, 1e-8);
  EXPECT_LT(end.connectors[0].length, 0.51);
  const Vec3 before = angular_momentum(start, Vec3::Zero());
  EXPECT_LT((angular_momentum(end, Vec3::Zero()) - before).norm(), 1e-7 * before.norm());
}

// A rope that runs along its own line keeps any shape, under the tension density * speed^2.
TEST(Winch, RunningRopeKeepsItsShape) {
  const World world = running(5), end = after(world, 0.5, 1e-6);
  EXPECT_LT(apart(end, world), 1e-12);
  const double expected = world.connectors[0].winch->density * 25;
  for (const std::size_t each : {0u, 1u}) {
    EXPECT_NEAR(winch_tension(end, 0, each), expected, 1e-9 * expected);
  }
}

// Between its two drums the tension of what runs straight through the air rises by the drag.
TEST(Winch, WhatRunsThroughTheAirIsDraggedAlong) {
  World world = running(5);
  Connector& rope = world.connectors[0];
  const Vec3 along = Vec3(0.6, 0.2, 0).normalized();
  for (std::size_t i = 0; i < rope.particles(); ++i) {
    rope.position[i] = along * static_cast<double>(i) / static_cast<double>(rope.links());
  }
  rope.holds[1].to.point = along;
  rope.sections.assign(rope.links(), Section{});
  for (Section& section : rope.sections) section.diameter = 0.01;
  rope.drag = {1, 0.5};
  world.air.density = 1.2;
  finish(world);
  const double drag = 1.2 / 2 * 0.01 * 0.5 * 25;
  const double drop = winch_tension(world, 0, 1) - winch_tension(world, 0, 0);
  EXPECT_NEAR(drop, drag, 1e-9 * drag);
}

TEST(Winch, SpringsAndXpbdComeNear) {
  const World start = hoist(5, 40);
  const World truth = after(start, 0.6, "truth", {});
  const auto error = [&](const char* method, const Settings& settings) {
    return apart(after(start, 0.6, method, settings), truth);
  };
  const double soft = error("springs", {{"stiffness", 1e4}}),
               stiff = error("springs", {{"stiffness", 1e6}});
  EXPECT_LT(stiff, 1e-3);
  EXPECT_GT(soft / stiff, 3);
  const double coarse = error("xpbd", {{"step", 4e-4}}), fine = error("xpbd", {{"step", 1e-4}});
  EXPECT_LT(fine, 1e-3);
  EXPECT_NEAR(coarse / fine, 4, 1);  // it is of first order
}

// With particles that share the mass by links, the model is of second order.
TEST(Winch, MoreParticlesComeNearToARope) {
  const auto load = [](std::size_t links) {
    World world = worlds::chain(links + 1, 1, worlds::from_down(40), 0.1);
    Connector& rope = world.connectors[0];
    const double part = 0.1 / static_cast<double>(links);
    rope.particle_mass.assign(links + 1, part);
    rope.particle_mass.front() = part / 2;
    rope.particle_mass.back() = part / 2 + 0.3;
    add_winches(world, rope, paying({{0, 0}, {1, 0.5}}), nullptr);
    Winch winch = *rope.winch;
    winch.density = 0.1;
    rope.winch = std::make_shared<const Winch>(winch);
    finish(world);
    return after(world, 0.8, 1e-8).connectors[0].position.back();
  };
  const Vec3 four = load(4), eight = load(8), sixteen = load(16);
  EXPECT_NEAR(std::log2((four - eight).norm() / (eight - sixteen).norm()), 2, 0.2);
}

TEST(Winch, CoarserWorldsHaveTheMassesOfTheExactOne) {
  World coarse = hoist(5, 40);
  const World exact = hoist(9, 40);
  take_masses(coarse, exact);
  finish(coarse);
  const auto sum = [](const World& world) {
    const std::vector<double>& all = world.connectors[0].particle_mass;
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  for (const double time : {0.0, 1.0, 3.0}) {
    World later = exact;
    place_held(coarse, time);
    place_held(later, time);
    EXPECT_NEAR(sum(coarse), sum(later), 1e-15) << time;
  }
}

TEST(Winch, TheTwoSolversOfTheTruthAgree) {
  const std::vector<double> times{0.1, 0.5};
  for (const Case& each : cases()) {
    const truth::Reference truth = truth::solve_truth(each.world, times);
    EXPECT_EQ(truth.horizon, 0.5) << each.name;
    EXPECT_LT(truth.self_error, 1e-6) << each.name;
  }
}

TEST(Winch, OthersRefuseByName) {
  std::size_t refused = 0;
  for (const MethodInfo& method : all_methods()) {
    if (method.abilities.follows.has(Feature::winch) || !method.missing.empty()) continue;
    World world = hoist(4, 0);
    try {
      make_method(method.name, {})->advance(world, 0.01);
      ADD_FAILURE() << method.name;
    } catch (const Diverged& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("winches"), std::string::npos) << refusal.what();
      ++refused;
    }
  }
  EXPECT_GE(refused, 3u);
}

/// A rope of strings or rods from a winch over a smooth post to a load.
World over_a_post(bool pulls, double paid_out) {
  constexpr std::size_t kParticles = 25;
  constexpr double kLength = 1.2, kBefore = 0.5, kRound = 0.11;
  World world;
  Connector rope =
      straight_connector("rope", kLength, 0.05, kParticles, Vec3::Zero(), Vec3::UnitX());
  for (std::size_t i = 0; i < kParticles; ++i) {
    const double along = kLength * static_cast<double>(i) / (kParticles - 1) - kBefore;
    const double turned = std::clamp(along / kRound, 0.0, std::numbers::pi / 2);
    rope.position[i] = kRound * Vec3(std::sin(turned), std::cos(turned), 0);
    if (along < 0) rope.position[i].x() = along;
    if (turned == std::numbers::pi / 2) rope.position[i].y() = kRound * turned - along;
  }
  rope.radius = 0.01;
  rope.particle_mass.back() += 0.5;
  rope.holds = {{0, worlds::fixed_at(rope.position[0])}};
  rope.pulls = pulls;
  world.connectors = {rope};
  add_winches(world, world.connectors[0], paying({{0, 0}, {1, paid_out}}), nullptr);
  Obstacle post;
  post.name = "post";
  post.shape = cylinder_shape(kRound - rope.radius, 1, 0);
  post.place.rotation = Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()));
  world.obstacles = {post};
  finish(world);
  return world;
}

// The rope lies on the post as a polygon of its links.
TEST(Winch, LiftsALoadOverASmoothPostByXpbd) {
  for (const bool pulls : {false, true}) {
    for (const double paid_out : {-0.3, 0.2}) {
      const World start = over_a_post(pulls, paid_out);
      Simulation simulation(start, make_method("xpbd", {{"step", 1e-4}}));
      simulation.advance_to(1.5);
      const Vec3 load = simulation.world().connectors[0].position.back();
      EXPECT_NEAR(load.y() - start.connectors[0].position.back().y(), -paid_out, 0.006) << pulls;
      EXPECT_NEAR(load.x(), 0.11, 0.006);
    }
  }
}

// Rope that slides over a rough post is pulled by exp(mu pi / 2) times the load, and stretches so.
TEST(Winch, RopeThatStretchesSlidesOverARoughPostByXpbdAndSprings) {
  World start = over_a_post(false, -0.2);
  Connector& rope = start.connectors[0];
  rope.sections.assign(rope.links(), {.axial_stiffness = 200, .axial_damping = 2});
  add_winches(start, rope, paying({{0, 0}, {1, -0.2}}), nullptr);
  finish(start);
  const auto height = [&](std::string_view method, double friction, const Settings& settings) {
    World world = start;
    world.obstacles[0].kinetic_friction = world.obstacles[0].static_friction = friction;
    Simulation simulation(world, make_method(method, settings));
    simulation.advance_to(0.7);
    return simulation.world().connectors[0].position.back().y();
  };
  const double rough = height("direct", 0.3, {{"tolerance", 1e-4}});
  EXPECT_LT(rough, height("direct", 0, {{"tolerance", 1e-4}}) - 0.005);
  EXPECT_NEAR(height("xpbd", 0.3, {{"step", 1e-5}}), rough, 2e-3);
  EXPECT_NEAR(height("springs", 0.3, {}), rough, 3e-4);
}

TEST(Winch, WorldsSayWhatIsWrongWithTheirs) {
  World pinned = hoist(5, 0);
  pinned.connectors[0].holds.push_back({2, worlds::fixed_at(pinned.connectors[0].position[2])});
  EXPECT_NE(winch_flaw(pinned).find("between its ends"), std::string::npos);
  World loose = hoist(5, 0);
  loose.connectors[0].holds.clear();
  EXPECT_THROW(finish(loose), std::invalid_argument);
}

/// The hoist with a rope that stretches.
World elastic(std::size_t particles, double stiffness) {
  World world = hoist(particles, 40);
  Section section;
  section.axial_stiffness = stiffness;
  world.connectors[0].sections.assign(particles - 1, section);
  refresh(world);
  return world;
}

// m x'' = m g - EA (x / h - 1) of a load on a rope without mass that is h(t) long at rest.
TEST(Winch, LiftsALoadOnARopeThatStretches) {
  constexpr double kStiffness = 200, kMass = 0.8, kEnd = 0.7;
  World world = worlds::chain(2, 1, worlds::from_down(0), 0);
  Connector& rope = world.connectors[0];
  rope.particle_mass.back() = kMass;
  Section section;
  section.axial_stiffness = kStiffness;
  rope.sections.assign(1, section);
  add_winches(world, rope, paying({{0, 0}, {1, -0.5}}), nullptr);
  finish(world);
  const auto pull = [&](double x, double time) {
    return kStiffness * (x / (1 + rope.winch->paid_out(0, time).length) - 1);
  };
  constexpr int kSteps = 20000;
  double x = 1, v = 0;
  for (int i = 0; i < kSteps; ++i) {  // Runge and Kutta's method of order 4
    const double h = kEnd / kSteps, time = h * i;
    const auto slope = [&](double at, double t) { return kGravity - pull(at, t) / kMass; };
    const double a = slope(x, time), b = slope(x + h / 2 * v, time + h / 2),
                 c = slope(x + h / 2 * v + h * h / 4 * a, time + h / 2),
                 d = slope(x + h * v + h * h / 2 * b, time + h);
    x += h * v + h * h / 6 * (a + b + c);
    v += h / 6 * (a + 2 * b + 2 * c + d);
  }
  const World end = after(world, kEnd, 1e-7);
  EXPECT_NEAR(end.connectors[0].position[1].y(), -x, 5e-7);
  EXPECT_NEAR(winch_tension(end, 0, 0), pull(x, kEnd), 1e-4);
}

// The rope gains the work of the drum, which pulls with T and moves (1 + T/EA) times as fast as the
// rope at rest is paid out, less the energy EA (T/EA)^2 / 2 that a unit of length carries.
TEST(Winch, ElasticRopeGainsTheWorkOfItsWinch) {
  constexpr double kStiffness = 60;
  const World start = elastic(6, kStiffness);
  Simulation simulation(start, make_method("direct", {{"tolerance", 1e-6}}));
  const double work = winch_work(simulation, 400, 2e-3, kStiffness);
  EXPECT_NEAR(energy(simulation.world()) - energy(start), work, 1e-5 * energy_scale(start));
  EXPECT_GT(std::abs(work), 0.01);
}

// The stiffer the rope, the nearer it is to one that does not stretch.
TEST(Winch, StifferRopesComeNearToRigidOnes) {
  const World rigid = after(hoist(6, 40), 0.6, 1e-7);
  double before = 1;
  for (const double stiffness : {1e3, 1e4, 1e5}) {
    const double now = apart(after(elastic(6, stiffness), 0.6, 1e-5), rigid);
    EXPECT_LT(now, before / 5) << stiffness;
    before = now;
  }
  EXPECT_LT(before, 1e-3);
}

/// A hoist at whose end two slings carry loads, straight down or spread.
World slung(double degrees) {
  World world = hoist(6, degrees);
  const Vec3 hook = world.connectors[0].position.back();
  for (const double side : {-1.0, 1.0}) {
    Connector sling = straight_connector(side < 0 ? "left" : "right", 0.4, 0.05, 4, hook,
                                         worlds::from_down(degrees == 0 ? 0 : degrees + 40 * side));
    sling.particle_mass.back() += 0.2;
    world.connectors.push_back(sling);
  }
  world.joints = {{{{0, 5}, {1, 0}, {2, 0}}}};
  finish(world);
  return world;
}

// Rope flows past no particle of the end that is joined.
TEST(Winch, LiftsSlingsThatAreJoinedToItsEnd) {
  Simulation straight(slung(0), make_method("direct", {{"tolerance", 1e-7}}));
  for (const double time : {0.3, 0.8, 1.7}) {
    straight.advance_to(time);
    const World& world = straight.world();
    const Winch& winch = *world.connectors[0].winch;
    const double mass =
        0.3 + 0.1 / 6 / 2 + winch.density * world.connectors[0].length + 2 * (0.2 + 0.05);
    const double expected = mass * (kGravity - winch.paid_out(0, time).acceleration);
    EXPECT_NEAR(winch_tension(world, 0, 0), expected, 1e-6 * expected) << time;
  }
  const World start = slung(30);
  Simulation spread(start, make_method("direct", {{"tolerance", 1e-6}}));
  const double work = winch_work(spread, 400, 2e-3);
  EXPECT_GT(std::abs(work), 0.1);
  EXPECT_NEAR(energy(spread.world()) - energy(start), work, 1e-5 * std::abs(work));
}

}  // namespace
}  // namespace taut::winch_test
