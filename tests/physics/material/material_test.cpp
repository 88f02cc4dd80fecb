// Shapes at rest and speeds that are known beforehand, of what stretches, bends and meets the air.
#include <gtest/gtest.h>

#include "material_worlds.h"

namespace taut::material_test {
namespace {

using namespace material_worlds;

/// The rate (1/s) at which a small bow of a clamped column grows under a weight on its end, where a
/// damper a million times as strong as its inertia brakes it.
double growth(double share_of_critical) {
  const double critical = std::numbers::pi * std::numbers::pi / 4;  // of EI = 1, by Euler
  Section made = section(kRigid, 1);
  made.bending_damping = 1;
  World world = rope(100, 1e-9, made, true);
  Connector& column = world.connectors[0];
  column.holds[0].clamp = Vec3::UnitY();
  for (std::size_t k = 0; k < column.links(); ++k) {
    const double lean =
        1e-6 * std::sin(std::numbers::pi / 2 * (static_cast<double>(k) + 0.5) / 100);
    column.position[k + 1] = column.position[k] + Vec3(std::sin(lean), std::cos(lean), 0) / 100;
  }
  world.gravity = Vec3(0, -1e4, 0);
  column.particle_mass.back() = share_of_critical * critical / 1e4;
  finish(world);
  // Other modes than that bow have died away by then, at rates near 1/s.
  const World early = after(world, 8, 1e-8), late = after(early, 12, 1e-8);
  const double grown =
      late.connectors[0].position.back().x() / early.connectors[0].position.back().x();
  return std::log(grown) / 4;
}

// (EI + damping s) k^2 = P for a bow that goes as exp(s t): s = P / P_critical - 1 here.
TEST(LongColumn, BucklesWhereEulerSays) {
  const double below = growth(0.98), above = growth(1.02);
  EXPECT_LT(below, 0);
  EXPECT_GT(above, 0);
  EXPECT_NEAR(0.98 + 0.04 * below / (below - above), 1, 1e-3);
  EXPECT_NEAR(above - below, 0.04, 0.04 * 1e-2);
}

// Wind presses on a light rope with a heavy end, half of it on the end: the whole rests where that
// half balances the weight, and swings there from the vertical to twice that angle. The rope's
// weight, and its speed against the wind's, are below 1% of it each.
TEST(Air, WindLeansARope) {
  World world = rope(20, 0.01, section(kRigid, 0), false);
  Connector& hangs = world.connectors[0];
  for (std::size_t i = 0; i < hangs.particles(); ++i) {
    hangs.position[i] = -static_cast<double>(i) / 20 * Vec3::UnitY();
  }
  hangs.particle_mass.back() += 1;
  hangs.drag = {1.2, 0};
  world.air = {1.2, Vec3(3, 0, 0)};
  finish(world);
  const double period = 2 * std::numbers::pi / std::sqrt(worlds::kGravity);
  const World out = after(world, period / 2, 1e-6);
  const double force = 1.2 * 1 * 0.01 / 2 * 1.2 * 9;
  EXPECT_NEAR(out.connectors[0].position.back().x() / (force / worlds::kGravity), 1, 0.02);
}

// A rope that is free at one end lies straight in the wind, at the angle a to it at which what it
// weighs across itself and its drag balance, link by link: w cos a = c sin^2 a per length. Drag
// along it changes nothing but the tension. It comes back there from another angle.
TEST(Air, ARopeInTheWindLiesStraight) {
  World world = rope(20, 0.05, section(kRigid, 0), false);
  Connector& flies = world.connectors[0];
  const double weight = 0.05 * worlds::kGravity, drag = 1.2 / 2 * 1.2 * 0.01 * 49;
  const double cosine =  // of c cos^2 a + w cos a - c = 0
      (std::sqrt(weight * weight + 4 * drag * drag) - weight) / (2 * drag);
  const double angle = std::acos(cosine);
  const auto along = [](double turn) { return Vec3(std::cos(turn), -std::sin(turn), 0); };
  flies.drag = {1.2, 0.1};
  world.air = {1.2, Vec3(7, 0, 0)};
  for (std::size_t i = 0; i < flies.particles(); ++i) {
    flies.position[i] = static_cast<double>(i) / 20 * along(angle + 0.1);
  }
  finish(world);
  const World end = after(world, 20, 1e-6);
  for (std::size_t i = 0; i < flies.particles(); ++i) {
    const Vec3 expected = static_cast<double>(i) / 20 * along(angle);
    EXPECT_LT((end.connectors[0].position[i] - expected).norm(), 1e-6);
  }
}

// A rope that lies across a wind whose strength changes moves as one of its links does:
// v' = c (w(t) - v) |w(t) - v|, here by Runge and Kutta's method.
TEST(Air, GustsAreFollowed) {
  World world = rope(10, 0.1, section(kRigid, 0), false);
  Connector& floats = world.connectors[0];
  for (std::size_t i = 0; i < floats.particles(); ++i) {
    floats.position[i] = static_cast<double>(i) / 10 * Vec3::UnitX();
  }
  floats.holds.clear();
  floats.drag = {1.2, 0};
  world.gravity.setZero();
  world.air = {
      1.2, Vec3::Zero(),
      std::make_shared<const Path>(std::vector<PathKey>{
          {0, Vec3(0, 2, 0)}, {0.5, Vec3(0, 9, 0)}, {1.1, Vec3(0, -4, 0)}, {2, Vec3(0, 6, 0)}})};
  finish(world);
  const double share = 1.2 / 2 * 1.2 * 0.01 * 0.1 / floats.particle_mass[1];
  double speed = 0, way = 0;
  const auto rate = [&](double time, double v) {
    const double past = world.air.wind_at(time).y() - v;
    return share * past * std::abs(past);
  };
  constexpr int kSteps = 20000;
  constexpr double kStep = 2.0 / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double t = i * kStep, half = kStep / 2;
    const double a = rate(t, speed), b = rate(t + half, speed + half * a);
    const double c = rate(t + half, speed + half * b), d = rate(t + kStep, speed + kStep * c);
    way += kStep * speed + kStep * kStep / 6 * (a + b + c);
    speed += kStep / 6 * (a + 2 * b + 2 * c + d);
  }
  const World end = after(world, 2, 1e-9);
  EXPECT_NEAR(end.connectors[0].position[5].y(), way, 1e-7);
  EXPECT_NEAR(end.connectors[0].velocity[5].y(), speed, 1e-7);
}

TEST(Material, ElasticEnergyIsCounted) {
  World world = rope(1, 1, section(50, 0), false);
  const double before = energy(world);
  world.connectors[0].position[1] *= 1.2;
  EXPECT_NEAR(energy(world) - before, 50 * 0.2 * 0.2 / 2, 1e-12);
  World bent = rope(2, 1, section(kRigid, 3), false);
  const double straight = energy(bent);
  bent.gravity.setZero();
  bent.connectors[0].position[2] = bent.connectors[0].position[1] + Vec3(0, 0.5, 0);
  // C = 2 tan(45 degrees) over half a metre.
  EXPECT_NEAR(energy(bent) - straight, 3 / 0.5 * 4 / 2, 1e-12);
}

}  // namespace
}  // namespace taut::material_test
