// Twist of connectors that are clamped at both ends.
#include "sim/world/twist.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "material_worlds.h"
#include "sim/material/forces.h"
#include "tests/physics/joined/joined_worlds.h"

namespace taut::twist_test {
namespace {

using namespace material_worlds;

std::shared_ptr<const Path> turns(std::vector<std::pair<double, double>> keys) {
  std::vector<PathKey> list;
  for (const auto& [time, angle] : keys) list.push_back({time, Vec3(angle, 0, 0)});
  return std::make_shared<const Path>(list);
}

Section twisting(double axial, double bending, double twisting) {
  Section made = section(axial, bending);
  made.twisting_stiffness = twisting;
  return made;
}

/// A metre of rope through these directions, clamped at both ends, weightless.
World through(const std::vector<Vec3>& directions, const Vec3& first, const Vec3& last,
              const Section& made) {
  World world = rope(directions.size(), 0.1, made, true);
  world.gravity.setZero();
  Connector& rod = world.connectors[0];
  const double link = 1 / static_cast<double>(directions.size());
  for (std::size_t k = 0; k < directions.size(); ++k) {
    rod.position[k + 1] = rod.position[k] + link * directions[k].normalized();
  }
  rod.holds[0].clamp = first;
  Hold end{directions.size(), {}};
  end.to.point = rod.position.back();
  end.clamp = last;
  rod.holds.push_back(end);
  finish(world);
  return world;
}

/// Bent in space: a piece of a helix whose tangent makes an angle of one radian with y.
World helix(std::size_t links, const Section& made) {
  const auto tangent = [&](double s) {
    return Vec3(std::sin(1.0) * std::cos(5 * s), std::cos(1.0), std::sin(1.0) * std::sin(5 * s));
  };
  std::vector<Vec3> directions;
  for (std::size_t k = 0; k < links; ++k) {
    directions.push_back(tangent((static_cast<double>(k) + 0.5) / static_cast<double>(links)));
  }
  return through(directions, tangent(0), tangent(1), made);
}

World straight(std::size_t links, const Section& made) {
  return through(std::vector<Vec3>(links, Vec3::UnitX()), Vec3::UnitX(), Vec3::UnitX(), made);
}

// m L / GJ, and twist of a rod of two halves shares out as their softness.
TEST(Twist, EnergyOfAStraightRod) {
  World world = straight(10, twisting(kRigid, 0.3, 2));
  EXPECT_EQ(elastic_energy(world), 0);
  world.connectors[0].holds[1].turn = turns({{0, 3}});
  EXPECT_NEAR(elastic_energy(world), 2 * 3 * 3 / 2.0, 1e-12);
  world.connectors[0].holds[0].turn = turns({{0, -1}});
  EXPECT_NEAR(elastic_energy(world), 2 * 4 * 4 / 2.0, 1e-12);
  for (std::size_t k = 0; k < 10; ++k) {
    world.connectors[0].sections[k].rest_twist = 1;
    if (k >= 5) world.connectors[0].sections[k].twisting_stiffness = 6;
  }
  EXPECT_NEAR(elastic_energy(world), 1 / (0.5 / 2 + 0.5 / 6) * 3 * 3 / 2.0, 1e-12);
}

/// The forces of what is bent and twisted, at each particle, N.
std::vector<Vec3> elastic_forces(const World& world) {
  material::MaterialForces forces;
  forces.rebuild(world, 0);
  forces.place(world, world.time);
  const Connector& rod = world.connectors[0];
  std::vector<Vec3> found(rod.particles(), Vec3::Zero());
  EXPECT_EQ(forces.twists().size(), 1u);
  forces.add(rod.position.data()->data(), rod.velocity.data()->data(), found);
  return found;
}

// By differences of second order.
TEST(Twist, ForcesFollowFromTheEnergy) {
  constexpr double h = 1e-6;
  World world = helix(8, twisting(kRigid, 0.3, 2));
  world.connectors[0].holds[1].turn = turns({{0, 3}});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> dice(-0.1, 0.1);
  for (Vec3& position : world.connectors[0].position) {
    position += Vec3(dice(random), dice(random), dice(random));
  }
  const std::vector<Vec3> force = elastic_forces(world);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < force.size(); ++i) {
    sum += force[i];
    for (int axis = 0; axis < 3; ++axis) {
      World more = world, less = world;
      more.connectors[0].position[i][axis] += h;
      less.connectors[0].position[i][axis] -= h;
      EXPECT_NEAR((elastic_energy(less) - elastic_energy(more)) / (2 * h), force[i][axis], 1e-6);
    }
  }
  EXPECT_LT(sum.norm(), 1e-12);
}

// The moment of all forces about the origin is what the clamps lack of balance: twist stays where
// all turns as one stiff piece, clamps included.
TEST(Twist, StaysWhereAllTurnsAsOne) {
  World world = helix(8, twisting(kRigid, 0.3, 2));
  world.connectors[0].holds[1].turn = turns({{0, 3}});
  const double before = elastic_energy(world);
  const Quat turn(Eigen::AngleAxisd(2, Vec3(1, 2, -3).normalized()));
  std::vector<PathKey> key{{0, Vec3::Zero(), turn}};
  for (Hold& hold : world.connectors[0].holds) {
    hold.to.kind = Attachment::Kind::path;
    hold.to.path = std::make_shared<const Path>(key);
  }
  for (Vec3& position : world.connectors[0].position) position = turn * position;
  EXPECT_NEAR(elastic_energy(world), before, 1e-12);
}

// The second derivatives of the twist by the edge between two carries, and by two edges.
TEST(Twist, SecondDerivativesOfACarry) {
  constexpr double h = 1e-6;
  const Vec3 before(0.3, 0.2, -0.1), behind(0.1, 0.4, 0.3), middle(0.4, 0.1, 0.2);
  const auto slope = [&](const Vec3& at) {
    return Vec3((material::Carry(before, at).slope() + material::Carry(at, behind).slope()) /
                at.norm());
  };
  const Mat3 own = material::Carry(before, middle).second().e1_e1 +
                   material::Carry(middle, behind).second().e0_e0;
  const Mat3 mixed = material::Carry(middle, behind).second().e0_e1;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 by = h * Vec3::Unit(axis);
    EXPECT_LT(((slope(middle + by) - slope(middle - by)) / (2 * h) - own.col(axis)).norm(), 1e-7);
    const Vec3 change = (material::Carry(middle, behind + by).slope() -
                         material::Carry(middle, behind - by).slope()) /
                        (2 * h * middle.norm());
    EXPECT_LT((change - mixed.col(axis)).norm(), 1e-7);
  }
}

// A clamp on a path that turns it three times about a straight rod twists it by three turns.
TEST(Twist, IsFollowedOverWholeTurns) {
  const double third = 2 * std::numbers::pi / 3;
  for (const char* method : {"direct", "truth", "springs", "xpbd"}) {
    World world = straight(4, twisting(1e3, 1, 0.1));
    std::vector<PathKey> keys;
    for (int k = 0; k <= 9; ++k) {
      keys.push_back({0.1 * k, Vec3::UnitX(), Quat(Eigen::AngleAxisd(k * third, Vec3::UnitX()))});
    }
    Hold& end = world.connectors[0].holds[1];
    end.to = {.kind = Attachment::Kind::path,
              .point = Vec3::Zero(),
              .path = std::make_shared<const Path>(keys)};
    finish(world);
    const World turned = after(world, 1, method, {});
    EXPECT_NEAR(turned.connectors[0].end_turn.since, 6 * std::numbers::pi, 1e-12) << method;
    EXPECT_NEAR(elastic_energy(turned), 0.1 * std::pow(6 * std::numbers::pi, 2) / 2, 1e-9)
        << method;
  }
}

/// The least moment times length over EI at which a rod under the tension T buckles, clamped at
/// both ends a length apart: EI w'''' - i M w''' - T w'' = 0 for w the deflection as a complex
/// number, w = w' = 0 at both ends. With b = M L / 2 EI, t = T L^2 / EI and r^2 = b^2 - t:
///   2 (cos r - cos b) = t sin(r) / r,
/// Greenhill's tan b = b, M L / EI = 8.987, without tension.
double critical_moment(double tension) {
  const auto left = [&](double b) {
    if (tension == 0) return std::sin(b) - b * std::cos(b);
    const double r = std::sqrt(b * b - tension);
    return 2 * (std::cos(r) - std::cos(b)) - tension * std::sin(r) / r;
  };
  double low = std::sqrt(tension) + 1, high = low;
  while (left(low) * left(high) > 0) high += 0.01;
  while (high - low > 1e-12) {
    const double middle = (low + high) / 2;
    (left(low) * left(middle) > 0 ? low : high) = middle;
  }
  return 2 * low;
}

/// The rate (1/s) at which a small bow of such a rod, of EI = 1, grows where a damper a million
/// times as strong as its inertia brakes it: (EI + damping s) takes the place of EI in a bow that
/// goes as exp(s t).
World growth_world(std::size_t links, double moment, double tension) {
  constexpr double kAxial = 1e6;
  Section made = twisting(kAxial, 1, 3);
  made.bending_damping = 1;
  made.axial_damping = 1e-2 * kAxial;
  World world = straight(links, made);
  Connector& rod = world.connectors[0];
  for (std::size_t i = 0; i < rod.particles(); ++i) {
    rod.position[i] *= 1 + tension / kAxial;
    const double x = static_cast<double>(i) / static_cast<double>(links);
    const double bow = 1e-5 * std::pow(std::sin(std::numbers::pi * x), 2);
    rod.position[i] += bow * Vec3(0, std::cos(4.5 * x), std::sin(4.5 * x));
  }
  rod.holds[1].to.point *= 1 + tension / kAxial;
  rod.holds[1].turn = turns({{0, moment / 3}});
  finish(world);
  return world;
}

double growth(std::size_t links, double moment, double tension) {
  const World world = growth_world(links, moment, tension);
  // Other modes than that bow have died away by then.
  const auto bow = [](const World& at) {
    double sum = 0;
    for (const Vec3& p : at.connectors[0].position) sum += p.y() * p.y() + p.z() * p.z();
    return std::sqrt(sum);
  };
  const World early = after(world, 30, 1e-9), late = after(early, 34, 1e-9);
  return std::log(bow(late) / bow(early)) / 4;
}

double measured_critical(std::size_t links, double tension) {
  const double expected = critical_moment(tension);
  const double below = growth(links, 0.98 * expected, tension);
  const double above = growth(links, 1.02 * expected, tension);
  EXPECT_LT(below, 0);
  EXPECT_GT(above, 0);
  if (tension == 0) {
    EXPECT_NEAR(above - below, 0.04, 0.04 * 2e-2);
  }
  return (0.98 + 0.04 * below / (below - above)) * expected;
}

// Of second order in the links.
TEST(Twist, RodsBuckleWhereGreenhillSays) {
  EXPECT_NEAR(critical_moment(0), 8.98682, 1e-5);
  for (const double tension : {0.0, 20.0}) {
    const double expected = critical_moment(tension);
    const double coarse = measured_critical(50, tension) / expected - 1;
    const double fine = measured_critical(100, tension) / expected - 1;
    EXPECT_LT(std::abs(fine), 1e-3) << tension;
    EXPECT_NEAR(coarse / fine, 4, 0.5) << tension;
  }
}

/// A ring of EI = 1 and unit length, its twisting moment a share of Michell's, sqrt(3) EI / R, and
/// bent by little out of its plane and in it, in two waves.
World michell_ring(std::size_t sides, double share, double damping) {
  const double radius = 1 / (2 * std::numbers::pi);
  Section made = twisting(kRigid, 1, 3);
  made.bending_damping = damping;
  made.rest_twist = -share * std::sqrt(3) / radius / made.twisting_stiffness;
  World world = joined_worlds::ring(sides, radius, 1e4);
  world.gravity.setZero();
  Connector& loop = world.connectors[0];
  loop.sections.assign(sides, made);
  finish(world);
  for (std::size_t i = 0; i <= sides; ++i) {
    const Vec3 at = loop.position[i];
    loop.position[i].z() += 1e-5 * std::cos(2 * std::atan2(at.y(), at.x()));
  }
  finish(world);
  return world;
}

/// The rate (1/s) at which that grows where a damper brakes it.
double ring_growth(std::size_t sides, double share) {
  // In two waves round the ring: what turns and moves as a whole is not in it.
  const auto wave = [](const World& world) {
    const Connector& loop = world.connectors[0];
    Eigen::Vector2d sum(0, 0);
    for (std::size_t i = 0; i < loop.links(); ++i) {
      const double angle =
          4 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(loop.links());
      sum += loop.position[i].z() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    return sum.norm();
  };
  const World start = michell_ring(sides, share, 1);
  const World early = after(start, 8, 1e-9), late = after(early, 12, 1e-9);
  return std::log(wave(late) / wave(early)) / 4;
}

/// Where that is zero, by secants.
double critical_share(std::size_t sides) {
  double before = 0.98, share = 1.02, growth = ring_growth(sides, before);
  for (int step = 0; step < 2; ++step) {
    const double next = ring_growth(sides, share);
    const double root = share - next * (share - before) / (next - growth);
    before = share;
    growth = next;
    share = root;
  }
  return share;
}

// A ring of a straight rod leaves its plane at a twist of 2 pi sqrt(3) EI/GJ (Michell 1889; Zajac,
// Stability of two planar loop elasticas, 1962), of second order in the links.
TEST(LongTwist, RingsBuckleWhereMichellSays) {
  const double coarse = critical_share(20) - 1, fine = critical_share(40) - 1;
  EXPECT_NEAR(coarse / fine, 4, 0.2);
  EXPECT_NEAR(fine - (coarse - fine) / 3, 0, 1e-3);
}

World swinging(double axial, double twisting_damping = 0) {
  Section made = twisting(axial, 0.05, 0.08);
  made.twisting_damping = twisting_damping;
  World world = helix(10, made);
  world.connectors[0].holds[1].turn = turns({{0, 4}});
  world.gravity = Vec3(0, -9.81, 0);
  return world;
}

TEST(Twist, MethodsAgreeOnItsSwing) {
  for (const double axial : {kRigid, 500.0}) {
    const World world = swinging(axial);
    const World truth = after(world, 0.5, "truth", {});
    EXPECT_GT(apart(truth, after(swinging(axial, 0.02), 0.5, "truth", {})), 1e-4);  // it is felt
    EXPECT_NEAR(energy(truth), energy(world), 1e-8);
    for (const double damping : {0.0, 0.02}) {
      const World start = swinging(axial, damping);
      const World end = after(start, 0.5, "truth", {});
      for (const double tolerance : {1e-3, 1e-5}) {
        EXPECT_LT(apart(after(start, 0.5, tolerance), end), tolerance) << axial << " " << damping;
      }
      if (!std::isfinite(axial)) continue;  // the games' methods stretch rigid links, too
      for (const char* method : {"springs", "xpbd"}) {
        const double coarse = apart(after(start, 0.5, method, {{"step", 1.0 / 15360}}), end);
        const double fine = apart(after(start, 0.5, method, {{"step", 1.0 / 61440}}), end);
        EXPECT_LT(fine, 1e-2) << method << " " << damping;
        EXPECT_GT(coarse / fine, 2.5) << method << " " << damping;
      }
    }
  }
}

}  // namespace
}  // namespace taut::twist_test
