// Rods that are curved at rest, in a plane.
#include <gtest/gtest.h>

#include <cmath>

#include "material_worlds.h"
#include "sim/material/elements.h"

namespace taut::rest_curvature_test {
namespace {

using namespace material_worlds;

constexpr double kCurvature = 2;  // 1/m

Section curved(double axial, double bending, double damping = 0) {
  Section made = section(axial, bending);
  made.rest_curvature = kCurvature * Vec3::UnitZ();
  made.bending_damping = damping;
  return made;
}

/// The angle from one link to the next, about z.
double turn(const Connector& rod, std::size_t particle) {
  const Vec3 e0 = rod.position[particle] - rod.position[particle - 1];
  const Vec3 e1 = rod.position[particle + 1] - rod.position[particle];
  return std::atan2(e0.cross(e1).z(), e0.dot(e1));
}

// The derivatives are those of the energy, by differences of second order.
TEST(RestCurvature, ForcesAndStiffnessFollowFromTheEnergy) {
  constexpr double h = 1e-5, stiffness = 1.7;
  const Vec3 rest(0.3, -0.2, 0.5);
  const Vec3 edges[] = {Vec3(0.4, 0.1, -0.2), Vec3(0.3, 0.35, 0.1)};
  const auto bend = [&](int edge, int axis, double by) {
    Vec3 moved[] = {edges[0], edges[1]};
    if (edge >= 0) moved[edge][axis] += by;
    return material::Bend(moved[0], moved[1], rest);
  };
  const auto slope = [&](const material::Bend& at, int edge) {
    Vec3 by[2];
    at.slope(stiffness, by[0], by[1]);
    return by[edge];
  };
  const material::Bend middle = bend(-1, 0, 0);
  const material::Bend::Stiffness second = middle.stiffness(stiffness);
  for (int axis = 0; axis < 3; ++axis) {
    for (int edge = 0; edge < 2; ++edge) {
      const material::Bend more = bend(edge, axis, h), less = bend(edge, axis, -h);
      EXPECT_NEAR((more.energy(stiffness) - less.energy(stiffness)) / (2 * h),
                  slope(middle, edge)[axis], 1e-8);
      for (int of = 0; of < 2; ++of) {
        const Vec3 change = (slope(more, of) - slope(less, of)) / (2 * h);
        const Mat3& block = of != edge ? second.e0_e1 : edge == 0 ? second.e0_e0 : second.e1_e1;
        const Mat3 by = of == 0 && edge == 1 ? block : Mat3(block.transpose());
        EXPECT_LT((change - by.col(axis)).norm(), 1e-7) << of << " by " << edge << " " << axis;
      }
    }
  }
}

// A straight rod that nothing holds comes to rest as a polygon about a circle of radius 1/k: each
// corner turns by 2 atan(k l / 2). Its slowest bow, of frequency 22.37 sqrt(EI / mass) = 7/s, dies
// away at damping / EI 7^2 / 2 = 2.5/s.
TEST(RestCurvature, AFreeRodRelaxesToItsArc) {
  for (const char* method : {"direct", "truth"}) {
    const std::size_t links = std::string_view(method) == "truth" ? 6 : 20;
    World world = rope(links, 0.1, curved(kRigid, 0.01, 0.001), false);
    world.gravity.setZero();
    world.connectors[0].holds.clear();
    finish(world);
    const Settings settings =
        std::string_view(method) == "truth" ? Settings{} : Settings{{"tolerance", 1e-6}};
    const World end = after(world, 8, method, settings);
    for (std::size_t i = 1; i < links; ++i) {
      EXPECT_NEAR(turn(end.connectors[0], i),
                  2 * std::atan(kCurvature / static_cast<double>(links) / 2), 1e-6)
          << method << " " << i;
    }
    EXPECT_LT(elastic_energy(end), 1e-12);
  }
}

/// A cantilever clamped along x, as it rests without weight: half of a link bends at the clamp.
World arc(std::size_t links, const Section& made) {
  World world = rope(links, 0.1, made, true);
  world.gravity.setZero();
  Connector& rod = world.connectors[0];
  const double link = 1 / static_cast<double>(links);
  double angle = 2 * std::atan(kCurvature * link / 4);
  for (std::size_t k = 0; k < links; ++k) {
    rod.position[k + 1] = rod.position[k] + link * Vec3(std::cos(angle), std::sin(angle), 0);
    angle += 2 * std::atan(kCurvature * link / 2);
  }
  finish(world);
  return world;
}

// By the games' methods, too: nothing pulls. Roundings of 1e-16 in a bend are 1e-8 in its root, by
// which xpbd moves.
TEST(RestCurvature, ACantileverKeepsItsArc) {
  for (const double axial : {kRigid, 1e3}) {
    const World world = arc(12, curved(axial, 0.1));
    EXPECT_LT(apart(after(world, 1, "truth", {}), world), 1e-9);
    EXPECT_LT(apart(after(world, 1, 1e-6), world), 1e-9);
    EXPECT_LT(apart(after(world, 1, "springs", {}), world), 1e-9);
    EXPECT_LT(apart(after(world, 1, "xpbd", {}), world), 1e-6);
  }
}

// Under its weight it swings: the tolerance is what the user gets, and energy stays.
TEST(RestCurvature, MethodsAgreeOnItsSwing) {
  for (const double axial : {kRigid, 500.0}) {
    World world = arc(10, curved(axial, 0.05));
    world.gravity = Vec3(0, -9.81, 0);
    const World truth = after(world, 0.5, "truth", {});
    EXPECT_NEAR(energy(truth), energy(world), 1e-8);
    for (const double tolerance : {1e-3, 1e-5}) {
      EXPECT_LT(apart(after(world, 0.5, tolerance), truth), tolerance) << axial;
    }
    if (!std::isfinite(axial)) continue;  // the games' methods stretch rigid links, too
    for (const char* method : {"springs", "xpbd"}) {
      EXPECT_LT(apart(after(world, 0.5, method, {{"step", 1.0 / 30720}}), truth), 1e-2) << method;
    }
  }
}

}  // namespace
}  // namespace taut::rest_curvature_test
