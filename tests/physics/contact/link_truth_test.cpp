// The truth of links that touch between their beads: known answers, energy, and the time stepping
// of the direct method, which shares no equation of motion with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "link_worlds.h"
#include "sim/measure/measure.h"
#include "sim/truth/truth.h"

namespace taut::link_truth_test {
namespace {

using namespace link_worlds;

Simulation by_truth(const World& world) {
  return {world, make_method("truth", {})};
}

double apart(const World& a, const World& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.connectors[0].particles(); ++i) {
    most = std::max(most, (a.connectors[0].position[i] - b.connectors[0].position[i]).norm());
  }
  return most;
}

/// A link that comes at v gets the impulse (1 + e) v/((1 - s)^2/m + s^2/m), in the shares 1 - s and
/// s for its beads.
TEST(LinkTruth, AnImpactActsByItsLevers) {
  for (const double speed : {0.1, 300.0}) {
    for (const double share : {0.02, 0.3, 0.5, 0.9}) {
      for (const double restitution : {0.0, 0.6, 1.0}) {
        Obstacle wire = post(kWire, Vec3::Zero());
        wire.restitution = restitution;
        World world = rod(share, 0, 0.0213, wire);
        world.gravity.setZero();
        for (Vec3& velocity : world.connectors[0].velocity) velocity = Vec3(0, -speed, 0);
        finish(world);
        Simulation simulation = by_truth(world);
        simulation.advance_to(0.0213 / speed * 1.001);  // less than a thousandth of a turn later
        const double impulse =
            (1 + restitution) * speed / ((1 - share) * (1 - share) + share * share);
        const Connector& after = simulation.world().connectors[0];
        // By what the rod has turned since, its beads' velocities have, too.
        const double turned = impulse * 0.0213 * 1e-3;
        EXPECT_NEAR(after.velocity[0].y(), (1 - share) * impulse - speed, turned)
            << speed << " " << share << " " << restitution;
        EXPECT_NEAR(after.velocity[1].y(), share * impulse - speed, turned);
        EXPECT_LE(penetration_of_links(simulation.world()), 1e-11);
      }
    }
  }
}

/// The centre of a rod that slides over a wire. With its angle q, e along it, n across, the centre
/// c at s = -e c from where it touches, the push N and the slip u = e c' there,
///   M c'' = M g + N (n - mu sgn(u) e),   I q'' = s N,   n c'' - q'' e c = 2 q' u + q'^2 r.
Vec3 sliding_centre(double angle, double offset, double friction, double until) {
  constexpr double r = kWire + kThickness;
  using State = Eigen::Matrix<double, 6, 1>;  // c, q, c', q'
  const auto rate = [&](const State& at) {
    const Eigen::Vector2d e(std::cos(at[2]), std::sin(at[2])), n(-e.y(), e.x()), g(0, -kGravity);
    const double s = -e.dot(at.head<2>()), slip = e.dot(at.segment<2>(3)), turns = at[5];
    const Eigen::Vector2d force = n - friction * (slip > 0 ? 1 : slip < 0 ? -1 : 0) * e;
    // Per mass; I = M/4 of two beads a metre apart.
    const double push = (2 * turns * slip + turns * turns * r - n.dot(g)) / (1 + 4 * s * s);
    State change;
    change << at.tail<3>(), g + push * force, 4 * s * push;
    return change;
  };
  const Vec3 along(std::cos(angle), std::sin(angle), 0), normal(-along.y(), along.x(), 0);
  const Vec3 centre = r * normal - offset * along;
  State at = State::Zero();
  at << centre.x(), centre.y(), angle, 0, 0, 0;
  // It begins to slide downwards.
  at.segment<2>(3) = -1e-300 * Eigen::Vector2d(along.x(), along.y());
  constexpr int kSteps = 4000;
  const double h = until / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const State a = rate(at), b = rate(at + h / 2 * a), c = rate(at + h / 2 * b),
                d = rate(at + h * c);
    at += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return {at[0], at[1], 0};
}

TEST(LinkTruth, ARodSlidesOverAWire) {
  constexpr double kAngle = 0.3, kOffset = 0.1, kUntil = 0.25;
  for (const double friction : {0.0, 0.1}) {
    const World world = rod(0.5 + kOffset, kAngle, 0, post(kWire, Vec3::Zero(), friction));
    Simulation simulation = by_truth(world);
    const double before = energy(simulation.world());
    simulation.advance_to(kUntil);
    const Connector& after = simulation.world().connectors[0];
    const Vec3 expected = sliding_centre(kAngle, kOffset, friction, kUntil);
    EXPECT_LT(((after.position[0] + after.position[1]) / 2 - expected).norm(), 1e-10) << friction;
    EXPECT_LE(penetration_of_links(simulation.world()), 1e-11);
    if (friction > 0) {
      EXPECT_LT(energy(simulation.world()), before - 1e-3);
    } else {
      EXPECT_NEAR(energy(simulation.world()), before, 1e-10);
    }
  }
}

/// On a wire under its middle a rod is in balance at any angle below that of friction.
TEST(LinkTruth, FrictionHoldsARodUpToItsAngle) {
  constexpr double kFriction = 0.5;  // atan 0.5 = 0.4636
  for (const double angle : {0.45, 0.48}) {
    Simulation simulation = by_truth(rod(0.5, angle, 0, post(kWire, Vec3::Zero(), kFriction)));
    const Vec3 from = simulation.world().connectors[0].position[0];
    simulation.advance_to(0.3);
    const double way = (simulation.world().connectors[0].position[0] - from).norm();
    if (angle < std::atan(kFriction)) {
      EXPECT_LT(way, 1e-10);
    } else {
      EXPECT_GT(way, 1e-3);
    }
  }
}

/// Housner (1963): a block that rocks keeps ((I - m a^2)/(I + m a^2))^2 of its energy as the other
/// edge, 2a aside, takes it over. The axis of the rod is a thin rod's radius above the edges.
TEST(LinkTruth, ARodThatRocksLosesWhatHousnerFound) {
  constexpr double kInertia = 0.25;  // m^2, over the mass
  for (const double half : {0.1, 0.2, 0.3}) {
    for (const double angle : {0.005, 0.03}) {
      const World world = rocking_rod(half, angle, 0);
      const double flat = 0.2 * kGravity * kThin, arm = half * half;
      const double kept = std::pow((kInertia - arm) / (kInertia + arm), 2);
      // At a constant torque it lands after sqrt(2 angle (I + a^2)/(g a)).
      const double lands = std::sqrt(2 * angle * (kInertia + arm) / (kGravity * half));
      Simulation simulation = by_truth(world);
      const double before = energy(world) - flat;
      simulation.advance_to(1.3 * lands);
      // With friction 1 it sticks to what it tips about, at a lever longer by its radius squared.
      EXPECT_NEAR((energy(simulation.world()) - flat) / before, kept, 1e-8) << half << ' ' << angle;
    }
  }
}

/// Without friction a rod stands on a post with its end, falls and goes on with what is beside it:
/// nothing arrives, and nothing takes energy. So it does where it slides off again past its end.
TEST(LinkTruth, ARodThatGoesOnBesideItsEndKeepsItsEnergy) {
  constexpr double kRadius = 0.3, kAngle = 0.3;
  World world;
  Connector rod = straight_connector("rod", 1, 0.1, 2, Vec3(0, kRadius + kThickness, 0),
                                     Vec3(std::cos(kAngle), std::sin(kAngle), 0));
  rod.radius = kThickness;
  rod.links_touch = true;
  world.connectors = {rod};
  world.obstacles = {post(kRadius, Vec3::Zero())};
  finish(world);
  Simulation simulation = by_truth(world);
  const double before = energy(world);
  bool along = false;
  for (int frame = 1; frame <= 60; ++frame) {
    simulation.advance_to(frame / 60.0);
    ASSERT_NEAR(energy(simulation.world()), before, 1e-10) << frame;
    ASSERT_LE(penetration_of_links(simulation.world()), 1e-11) << frame;
    const Connector& now = simulation.world().connectors[0];
    const contact::Capsule link{now.position[0], now.position[1], now.radius};
    const Obstacle& solid = world.obstacles[0];
    const double least = contact::least_gap(solid.shape, solid.frame(0).pose(), link);
    along = along || (least < 1e-10 && now.position[0].norm() > kRadius + kThickness + 1e-3);
  }
  EXPECT_TRUE(along);
}

/// No more energy than before, be it with friction, restitution or both.
TEST(LinkTruth, NoRopeGainsAnyOnThickPosts) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const World world = rope_on_posts(seed);
    Simulation simulation = by_truth(world);
    const double scale = energy_scale(world);
    double least = energy(world);
    for (int frame = 1; frame <= 30; ++frame) {
      simulation.advance_to(frame / 60.0);
      ASSERT_LE(energy(simulation.world()), least + 1e-9 * scale) << seed << ' ' << frame;
      ASSERT_LE(penetration_of_links(simulation.world()), 1e-10) << seed << ' ' << frame;
      ASSERT_LT(stretch_max(simulation.world()), 1e-9) << seed;
      least = std::min(least, energy(simulation.world()));
    }
  }
}

/// A chain of few links, or of strings, that swings from the horizontal against a thin post, which
/// moves if so.
World against_a_post(double friction, bool pulls, bool moves) {
  World world = worlds::chain(7, 1, Vec3::UnitX(), 0.1);
  Connector& chain = world.connectors[0];
  chain.radius = 0.005;
  chain.links_touch = true;
  chain.pulls = pulls;
  world.obstacles = {post(0.01, Vec3(0.25, -0.3, 0), friction)};
  if (moves) {
    world.obstacles[0].path = std::make_shared<const Path>(
        std::vector<PathKey>{{0, Vec3::Zero(), Quat::Identity(), true},
                             {1, Vec3(0.05, 0.1, 0), Quat::Identity(), true}});
  }
  world.topology = structure(world);
  return world;
}

/// With links that touch, where beads alone would pass the post. Of second order in the steps of
/// direct; of first with friction, as where in a step it slides or sticks is anyhow.
TEST(LongLinkTruth, TwoSolversAgree) {
  constexpr double kUntil = 0.42;
  for (const double friction : {0.0, 0.3}) {
    for (const bool pulls : {false, true}) {
      for (const bool moves : {false, true}) {
        const World world = against_a_post(friction, pulls, moves);
        Simulation truth = by_truth(world);
        truth.advance_to(kUntil);
        EXPECT_LE(penetration_of_links(truth.world()), 1e-11);
        EXPECT_LT(stretch_max(truth.world()), 1e-11);
        double first = 0, last = 0;
        for (const double step : {4e-4, 1e-4}) {
          Simulation other(world, make_method("direct", {{"step", step}}));
          other.advance_to(kUntil);
          last = apart(truth.world(), other.world());
          if (first == 0) first = last;
        }
        EXPECT_LT(last, (friction > 0 ? 0.5 : 0.1) * first) << friction << pulls << moves;
        EXPECT_LT(last, 1e-5) << friction << pulls << moves;
      }
    }
  }
}

/// Ropes of any size that fall on posts, without friction, until links leave a post past their
/// ends.
TEST(LinkTruth, TwoSolversAgreeOnSeededWorlds) {
  for (const auto& [seed, restitution] :
       {std::pair(1u, 0.0), std::pair(3u, 0.0), std::pair(1u, 1.0), std::pair(3u, 1.0)}) {
    const World world = rope_on_posts(seed, 0, restitution);
    Simulation truth = by_truth(world);
    truth.advance_to(0.6);
    double before = 0;
    for (const double step : {4e-4, 2e-4, 1e-4}) {
      Simulation other(world, make_method("direct", {{"step", step}}));
      other.advance_to(0.6);
      const double error = apart(truth.world(), other.world());
      if (before > 0) {
        EXPECT_LT(error, 0.3 * before) << seed << ' ' << restitution;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-6) << seed << ' ' << restitution;
  }
}

// The chain meets the post after 0.3 s.
TEST(LongLinkTruth, StatesHowFarItIsKnown) {
  std::vector<double> times;
  for (int frame = 0; frame <= 18; ++frame) times.push_back(frame / 30.0);
  const truth::TruthOptions options;
  const truth::Reference truth =
      truth::solve_truth(against_a_post(0.3, false, false), times, options);
  EXPECT_GE(truth.horizon, 0.4);
  EXPECT_GT(truth.self_error, 0);
  EXPECT_LE(truth.self_error, options.scored_error / 100);
}

}  // namespace
}  // namespace taut::link_truth_test
