// Friction of rope at pulleys, against known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "../material/material_worlds.h"
#include "../worlds.h"
#include "pulley_worlds.h"
#include "sim/links/tension.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/world/connector.h"
#include "sim/world/winched.h"

namespace taut::pulley_friction_test {
namespace {

using material_worlds::after;
using pulley_worlds::atwood;
using worlds::kGravity;

Settings finely(std::string_view method, double tolerance) {
  return method == "direct" ? Settings{{"tolerance", tolerance}} : Settings();
}

constexpr double kFriction = 0.2;
const double kHalfTurn = std::exp(kFriction * std::numbers::pi);  // T1/T2 over half a turn

TEST(PulleyFriction, RopeStaysWhereTheCapstanHolds) {
  for (const char* method : {"truth", "direct"}) {
    for (const double share : {0.999, 1 / 0.999}) {
      const World start =
          atwood({.left_mass = 1, .right_mass = share * kHalfTurn, .friction = kFriction});
      const World end = after(start, 1, method, {});
      if (share < 1) {
        EXPECT_EQ(end.pulleys[0].passed, 0) << method;
        EXPECT_EQ(end.pulleys[0].speed, 0) << method;
        EXPECT_LT((end.connectors[1].position[1] - Vec3(0, -1.2, 0)).norm(), 1e-14) << method;
      } else {
        EXPECT_GT(end.pulleys[0].passed, 1e-4) << method;
      }
    }
  }
}

// Thrown upwards a mass slides until friction and its weight have stopped it, and stays there.
TEST(PulleyFriction, RopeStopsWhereItMustAndStays) {
  const double left = 1, right = 1.2, speed = -1;  // the right mass rises
  const double slows = kGravity * (kHalfTurn * right - left) / (kHalfTurn * right + left);
  for (const char* method : {"truth", "direct"}) {
    World start = atwood({.left_mass = left, .right_mass = right, .friction = kFriction});
    pulley_worlds::set_passing(start, speed);
    const World early = after(start, 0.5 / slows, method, {});
    EXPECT_NEAR(early.pulleys[0].speed, -0.5, 1e-9) << method;
    const World end = after(start, 1, method, {});
    EXPECT_EQ(end.pulleys[0].speed, 0) << method;
    EXPECT_NEAR(end.pulleys[0].passed, -speed * speed / (2 * slows), 1e-9) << method;
  }
}

/// The same rope over two eyes at one height, a quarter of a turn about each.
World two_eyes(double left_mass, double right_mass) {
  World world;
  const Vec3 right_eye(0.7, 0, 0);
  const auto rope = [&](const char* name, const Vec3& from, const Vec3& to) {
    return straight_connector(name, (to - from).norm(), 0, 2, from, to - from);
  };
  Connector left = rope("left", -Vec3::UnitY(), Vec3::Zero()),
            middle = rope("middle", Vec3::Zero(), right_eye),
            right = rope("right", right_eye, right_eye - Vec3::UnitY());
  left.holds = {{1, worlds::fixed_at(Vec3::Zero())}};
  middle.holds = {{0, worlds::fixed_at(Vec3::Zero())}, {1, worlds::fixed_at(right_eye)}};
  right.holds = {{0, worlds::fixed_at(right_eye)}};
  left.particle_mass.front() += left_mass;
  right.particle_mass.back() += right_mass;
  world.connectors = {left, middle, right};
  add_pulley(world, "left", 0, 1, 0);
  add_pulley(world, "right", 1, 2, 0);
  for (Pulley& eye : world.pulleys) eye.friction = kFriction;
  finish(world);
  return world;
}

// Only the sum of the angles counts.
TEST(PulleyFriction, TwoQuarterTurnsHoldAsHalfATurn) {
  for (const char* method : {"truth", "direct"}) {
    const double fall = kGravity * (2.5 - kHalfTurn) / (2.5 + kHalfTurn);
    const World falls = after(two_eyes(1, 2.5), 0.4, method, {});
    for (const Pulley& eye : falls.pulleys) EXPECT_NEAR(eye.speed, fall * 0.4, 1e-9) << method;
    const World stays = after(two_eyes(1, 0.999 * kHalfTurn), 0.4, method, {});
    for (const Pulley& eye : stays.pulleys) EXPECT_NEAR(eye.passed, 0, 1e-15) << method;
  }
}

/// A heavy rope over an eye, of lengths a before and b behind it, with E = exp(mu pi):
/// density (b (g - q'') - q'^2) = E density (a (g + q'') - q'^2), by Runge and Kutta's method.
double slid(double a, double b, double duration) {
  const auto acceleration = [&](double q, double v) {
    const double before = a - q, behind = b + q;
    return (kGravity * (behind - kHalfTurn * before) + (kHalfTurn - 1) * v * v) /
           (behind + kHalfTurn * before);
  };
  constexpr int kSteps = 20000;
  const double h = duration / kSteps;
  double q = 0, v = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double a1 = acceleration(q, v), a2 = acceleration(q + h / 2 * v, v + h / 2 * a1),
                 v2 = v + h / 2 * a1, a3 = acceleration(q + h / 2 * v2, v + h / 2 * a2),
                 v3 = v + h / 2 * a2, a4 = acceleration(q + h * v3, v + h * a3), v4 = v + h * a3;
    q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return q;
}

TEST(PulleyFriction, HeavyRopeSlidesByItsEquation) {
  const double left = 0.8, right = 2.2, duration = 0.5;
  const double known = slid(left, right, duration);
  EXPECT_GT(known, 0.1);
  for (const std::size_t links : {1u, 2u, 6u}) {
    for (const char* method : {"truth", "direct"}) {
      World world = atwood({.left = left,
                            .right = right,
                            .left_mass = 0,
                            .right_mass = 0,
                            .density = 0.7,
                            .friction = kFriction,
                            .links = links});
      const World end = after(world, duration, method, finely(method, 1e-8));
      EXPECT_NEAR(end.pulleys[0].passed, known, 1e-7) << method << ' ' << links;
    }
  }
}

// The swinging machine loses what friction takes, sticks where it swings little, and truth and
// direct agree all the way.
TEST(PulleyFriction, SwingingRopeSlipsAndSticks) {
  const World start = atwood(
      {.left = 1, .right = 1, .left_mass = 1.2, .right_mass = 1, .degrees = 50, .friction = 0.1});
  bool stuck = false, slid = false;
  double before = energy(start);
  Simulation truth(start, make_method("truth", {}));
  Simulation direct(start, make_method("direct", {{"tolerance", 1e-6}}));
  for (int frame = 1; frame <= 120; ++frame) {
    truth.advance_to(0.05 * frame);
    direct.advance_to(0.05 * frame);
    const Pulley& eye = truth.world().pulleys[0];
    (eye.speed == 0 ? stuck : slid) = true;
    EXPECT_NEAR(direct.world().pulleys[0].passed, eye.passed, 2e-6) << frame;
    EXPECT_LE(energy(truth.world()), before + 1e-9) << frame;
    before = energy(truth.world());
  }
  EXPECT_TRUE(stuck);
  EXPECT_TRUE(slid);
  EXPECT_LT(before, energy(start) - 0.01);
}

// A winch lifts a load over an eye: what it pulls with is E times the load.
TEST(PulleyFriction, TheWinchFeelsTheEye) {
  for (const double passes : {-0.3, 0.3}) {  // m in a second, taken in or paid out
    World world = atwood({.left = 1, .left_mass = 0, .right_mass = 2, .friction = kFriction});
    Connector& left = world.connectors[0];
    left.holds.insert(left.holds.begin(), {0, worlds::fixed_at(left.position.front())});
    world.pulleys.clear();
    left.winch = world.connectors[1].winch = nullptr;
    std::vector<PathKey> keys{{0, Vec3::Zero(), Quat::Identity()},
                              {1, Vec3(passes, 0, 0), Quat::Identity()}};
    add_winches(world, left, std::make_shared<const Path>(std::move(keys)), nullptr);
    add_pulley(world, "eye", 0, 1, 0);
    world.pulleys[0].friction = kFriction;
    finish(world);
    const World end = after(world, 0.5, "direct", {{"tolerance", 1e-8}});
    const double ratio = passes < 0 ? kHalfTurn : 1 / kHalfTurn;
    EXPECT_NEAR(winch_tension(end, 0, 0), ratio * 2 * kGravity, 1e-6) << passes;
  }
}

}  // namespace
}  // namespace taut::pulley_friction_test
