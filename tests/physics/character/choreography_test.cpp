// Flat chains and choreographies against the simulation, which knows nothing of them.
#include "sim/choreography/choreography.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/choreography/flat_fit.h"
#include "sim/contact/capsule.h"
#include "sim/motion/rotation.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::choreography_test {
namespace {

constexpr double kRadius = 0.25, kLap = 1.3;  // m, s

/// A stick on a chain of so many particles that hangs at rest from a stick that a path holds.
World nunchaku(std::size_t particles, std::vector<PathKey> keys) {
  World world;
  Body stick;
  stick.name = "free";
  stick.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  Body held = stick;
  held.name = "held";
  held.grip = Vec3(0, 0.015, 0);
  const Vec3 top = keys[0].position + keys[0].rotation * Vec3(0, 0.135, 0);
  held.path = std::make_shared<const Path>(std::move(keys));
  Connector chain = straight_connector("chain", 0.12, 0.012, particles, top, -Vec3::UnitY());
  stick.position = chain.position.back() - Vec3(0, 0.15, 0);
  chain.holds = {{0, worlds::on_body(0, Vec3(0, 0.15, 0))},
                 {particles - 1, worlds::on_body(1, Vec3(0, 0.15, 0))}};
  world.bodies = {held, stick};
  world.connectors = {chain};
  finish(world);
  return world;
}

PathKey forward() {
  return {0, Vec3::Zero(), Quat(Eigen::AngleAxisd(std::numbers::pi / 3, Vec3::UnitX()))};
}

/// On a circle that lies askew, to the columns that are asked for.
choreography::TaylorSeries circle(double time, Eigen::Index columns) {
  const double rate = 2 * std::numbers::pi / kLap;
  choreography::TaylorSeries series(3, columns);
  double share = kRadius;
  for (Eigen::Index k = 0; k < columns; ++k) {
    const double angle = rate * time + std::numbers::pi / 2 * static_cast<double>(k);
    series.col(k) = share * Vec3(std::cos(angle), 0.4 * std::sin(angle), std::sin(angle));
    share *= rate / static_cast<double>(k + 1);
  }
  return series;
}

TEST(FlatChain, AConicalPendulumHasTheTensionOfItsRadius) {
  // A bead that goes round on a link of length l, the other end at rest: cos a = g / (w^2 l).
  const double length = 0.5, rate = 6, gravity = 9.81, mass = 0.3;
  const double height = gravity / (rate * rate),
               radius = std::sqrt(length * length - height * height);
  choreography::TaylorSeries series(3, 4);
  double share = radius;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const double angle = std::numbers::pi / 2 * static_cast<double>(k);
    series.col(k) = share * Vec3(std::cos(angle), 0, std::sin(angle));
    share *= rate / static_cast<double>(k + 1);
  }
  const choreography::FlatMotion motion =
      choreography::flat_motion({Vec3(0, -gravity, 0), {mass}, {length}}, series);
  EXPECT_NEAR(motion.tension[0], mass * rate * rate * length, 1e-12);
  EXPECT_LT((motion.particles[1].col(0) - Vec3(0, height, 0)).norm(), 1e-12);
  EXPECT_LT(motion.particles[1].col(1).norm(), 1e-12);
}

/// The hand's path in closed form, simulated: the stick's centre of oscillation goes round the
/// circle that it was made from, for every number of particles.
TEST(FlatChain, TheSimulationGivesTheFlatOutputBack) {
  for (const std::size_t particles : {2u, 3u, 11u}) {
    World world = nunchaku(particles, {forward()});
    const choreography::FlatChain chain = choreography::flat_chain(world, 1);
    ASSERT_EQ(chain.length.size(), particles);
    std::vector<PathKey> keys;
    constexpr double kStep = 0.01;      // s
    for (int k = -40; k <= 340; ++k) {  // a path is at rest at its first and last key
      const choreography::TaylorSeries end =
          choreography::flat_motion(chain, circle(kStep * k, chain.columns(1))).particles.back();
      keys.push_back({kStep * k, end.col(0), Quat::Identity()});
    }
    Connector& line = world.connectors[0];
    line.holds[0].to = worlds::on_path(std::make_shared<const Path>(keys));
    const choreography::FlatMotion start =
        choreography::flat_motion(chain, circle(0, chain.columns(2)));
    const std::size_t last = start.particles.size() - 1;
    for (std::size_t i = 0; i < particles; ++i) {
      line.position[i] = start.particles[last - i].col(0);
      line.velocity[i] = start.particles[last - i].col(1);
    }
    Body& stick = world.bodies[1];
    const Vec3 along = start.particles[0].col(0) - start.particles[1].col(0);
    const Vec3 turns = start.particles[0].col(1) - start.particles[1].col(1);
    stick.rotation = rotation_between(-Vec3::UnitY(), along);
    stick.spin = along.cross(turns) / along.squaredNorm();
    stick.position = start.particles[1].col(0) + 0.15 * along.normalized() +
                     stick.rotation * stick.mass_properties.centre;
    stick.velocity =
        start.particles[1].col(1) + stick.spin.cross(stick.position - start.particles[1].col(0));
    world.topology = structure(world);
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-7}}));
    for (int k = 1; k <= 30; ++k) {
      simulation.advance_to(0.1 * k);
      const Pose frame = simulation.state().bodies[1];
      const double arm = chain.length[0] - 0.15;
      EXPECT_LT((frame.to_world(Vec3(0, -arm, 0)) - circle(0.1 * k, 1).col(0)).norm(), 2e-5)
          << particles << " particles at " << 0.1 * k;
    }
  }
}

/// The driven end is no part of a flat chain, and what is there has no arm about it.
TEST(FlatChain, CoarserKeepsLengthAndMomentAboutTheDrivenEnd) {
  const choreography::FlatChain fine = choreography::flat_chain(nunchaku(11, {forward()}), 1);
  const choreography::FlatChain coarse = choreography::coarser(fine, 4);
  ASSERT_EQ(coarse.length.size(), 5u);
  EXPECT_EQ(coarse.mass[0], fine.mass[0]);
  const auto moment = [](const choreography::FlatChain& chain) {
    double length = 0, sum = 0;
    for (std::size_t i = chain.length.size(); i-- > 0;) {
      length += chain.length[i];
      sum += chain.mass[i] * length;
    }
    return Eigen::Vector2d(length, sum);
  };
  EXPECT_LT((moment(coarse) - moment(fine)).norm(), 1e-15);
  EXPECT_EQ(choreography::coarser(fine, 10).length, fine.length);
}

TEST(FlatChain, SaysWhatIsNotFlat) {
  World world = nunchaku(11, {forward()});
  EXPECT_EQ(choreography::why_not_flat(world, {}, 1), "");
  EXPECT_EQ(choreography::why_not_flat(world, {}, 0), "driven");
  World fixed = world;
  fixed.connectors[0].holds[0].to = worlds::fixed_at(Vec3::Zero());
  EXPECT_EQ(choreography::why_not_flat(fixed, {}, 1),
            "on a connector whose other end follows no path");
  world.bodies[1].bare.inertia(2, 2) *= 1.1;
  EXPECT_EQ(choreography::why_not_flat(world, {}, 1),
            "not of even moment about the line it hangs by");
}

TEST(GaussianSum, SeriesIsThatOfTheGaussian) {
  const choreography::GaussianSum sum{0.2, 0.1, 5};
  constexpr double kLater = 0.03;
  const choreography::GaussianSum::Local here = sum.at(0.33, 24), there = sum.at(0.33 + kLater, 1);
  ASSERT_EQ(here.series.rows(), there.series.rows());
  for (Eigen::Index i = 0; i < here.series.rows(); ++i) {
    double value = 0;
    for (Eigen::Index k = 23; k >= 0; --k) value = value * kLater + here.series(i, k);
    EXPECT_NEAR(value, there.series(i, 0), 1e-12);
  }
}

/// A figure-eight that the tip goes through twice, a lap in 1.6 s.
choreography::Choreography figure_eight() {
  choreography::Choreography problem;
  problem.world = nunchaku(11, {forward()});
  problem.body = 1;
  problem.point = Vec3(0, -0.15, 0);
  const Vec3 end = forward().rotation * Vec3(0, 0.135, 0);
  for (int k = 0; k <= 16; ++k) {
    const double angle = std::numbers::pi / 4 * k;
    problem.waypoints.push_back(
        {1 + 0.2 * k, end + Vec3(0.4 * std::sin(angle), -0.27 - 0.15 * std::cos(2 * angle), 0)});
  }
  problem.until = 5.6;
  problem.limits = {Vec3(0, 0.3, -0.4), 0.6, 1.0, 12};
  problem.pivot = 0.67;
  return problem;
}

TEST(Choreography, TheTipPassesItsPointsWithinTheLimitsOfTheHand) {
  const choreography::Choreography problem = figure_eight();
  double told = 1;
  const choreography::HandPath found =
      choreography::choreograph(problem, 0.002, [&](double miss) { told = miss; });
  EXPECT_LE(told, 0.002);
  EXPECT_LE(found.hand.reach, problem.limits.reach);
  EXPECT_LE(found.hand.speed, problem.limits.speed);
  EXPECT_LE(found.hand.acceleration, problem.limits.acceleration);
  EXPECT_GT(found.tension, 0.1);
  EXPECT_EQ(found.keys.front().position, Vec3::Zero());
  // Again by a finer simulation.
  const std::vector<double> again = choreography::misses(
      problem, choreography::with_hand_path(problem.world, 1, found.keys), 1e-5);
  ASSERT_EQ(again.size(), problem.waypoints.size());
  for (std::size_t k = 0; k < again.size(); ++k) EXPECT_NEAR(again[k], found.miss[k], 1e-4);
  // The held stick points away from its pivot, and stick and hand rest at the end.
  const choreography::HandFrame frame(problem.world, 1, problem.pivot);
  const PathKey& key = found.keys[found.keys.size() / 2];
  const Vec3 pivot = forward().rotation * Vec3(0, 0.135 - problem.pivot, 0);
  const Vec3 along = key.rotation * Vec3::UnitY(), from = key.position - pivot;
  EXPECT_LT(along.cross(from).norm(), 1e-9);
  Simulation simulation(choreography::with_hand_path(problem.world, 1, found.keys),
                        make_method("direct", {{"tolerance", 1e-6}}));
  simulation.advance_to(problem.until);
  EXPECT_LT(simulation.world().bodies[1].velocity.norm(), 0.05);
  EXPECT_LT((frame.rest() - simulation.world().connectors[0].position[0]).norm(), 1e-9);
}

/// A spin that stands upright, three turns of 0.56 s, of which the tip is above the hand half the
/// time.
choreography::Choreography upright_spin() {
  choreography::Choreography problem = figure_eight();
  problem.waypoints.clear();
  const Vec3 end = forward().rotation * Vec3(0, 0.135, 0);
  for (int k = 0; k <= 18; ++k) {
    const double angle = std::numbers::pi / 3 * k;
    problem.waypoints.push_back(
        {2 + 0.56 / 6 * k, end + 0.52 * Vec3(std::sin(angle), -std::cos(angle), 0)});
  }
  problem.until = 5.4;
  problem.limits = {Vec3(0, 0.3, -0.4), 0.8, 2.0, 40, 0.08};
  return problem;
}

TEST(LongChoreography, AnUprightSpinFromRestAndBackStaysClearOfWhatLeadsIt) {
  const choreography::Choreography problem = upright_spin();
  const choreography::HandPath found = choreography::choreograph(problem, 0.002);
  EXPECT_LE(*std::ranges::max_element(found.miss), 0.002);
  EXPECT_LE(found.hand.speed, problem.limits.speed);
  EXPECT_LE(found.hand.acceleration, problem.limits.acceleration);
  EXPECT_GT(found.tension, 0.1);
  // By the simulation: the stick from the line between the pivot and the chain's end.
  const Vec3 pivot = forward().rotation * Vec3(0, 0.135 - problem.pivot, 0);
  Simulation simulation(choreography::with_hand_path(problem.world, 1, found.keys),
                        make_method("direct", {{"tolerance", 1e-4}}));
  double clearance = 1;
  for (int k = 1; k <= 540; ++k) {
    simulation.advance_to(0.01 * k);
    const World& world = simulation.world();
    const Vec3 hangs = world.bodies[1].point(Vec3(0, 0.15, 0));
    const Vec3 tip = world.bodies[1].point(problem.point);
    clearance = std::min(
        clearance, contact::least_gap(contact::Capsule{world.connectors[0].position[0], pivot},
                                      contact::Capsule{hangs, tip}));
  }
  // A residual of 1 is a thirtieth of the clearance; the fit weighs it against waypoints.
  EXPECT_GT(clearance, 0.9 * problem.limits.clearance);
}

/// While they are taut, links that only pull move as rods do.
TEST(Choreography, LeadsAChainOfStrings) {
  choreography::Choreography problem = figure_eight();
  problem.waypoints.resize(5);
  problem.until = 3.2;
  problem.world.connectors[0].pulls = true;
  finish(problem.world);
  const choreography::HandPath found = choreography::choreograph(problem, 0.002);
  EXPECT_LE(*std::ranges::max_element(found.miss), 0.002);
}

TEST(LongChoreography, HasTheSameBitsAgain) {
  choreography::Choreography problem = figure_eight();
  problem.waypoints.resize(5);
  problem.until = 3.2;
  const choreography::HandPath one = choreography::choreograph(problem, 0.002),
                               other = choreography::choreograph(problem, 0.002);
  ASSERT_EQ(one.keys.size(), other.keys.size());
  EXPECT_EQ(Path(one.keys).fingerprint(), Path(other.keys).fingerprint());
}

TEST(Choreography, TellsHowFarItStaysOffWhereTheHandCannot) {
  choreography::Choreography problem = figure_eight();
  problem.waypoints.resize(3);
  problem.until = 3;
  problem.waypoints[1].position.x() += 2;  // m, from one point to the next and back in 0.4 s
  const choreography::HandPath found = choreography::choreograph(problem, 0.002);
  EXPECT_GT(*std::ranges::max_element(found.miss), 0.1);
}

}  // namespace
}  // namespace taut::choreography_test
