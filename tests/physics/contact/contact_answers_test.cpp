// Experiments with ropes at obstacles whose outcome is known beforehand; scenes/contact shows them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "contact_worlds.h"

namespace taut::contact_answers_test {
namespace {

using namespace contact_worlds;
using std::numbers::pi;
using worlds::kGravity;

/// A weight of 1 kg on a string of a metre is let go level with its nail; a peg's side is `below`
/// (m) the nail. The string winds up by an angle, from straight down.
struct Galileo {
  double radius = 0.02, below = 0;

  double free_length(double angle) const { return 1 - below - radius * angle; }

  /// Tension in N, where the string is taut: the weight's speed follows from how far it fell.
  double tension(double angle) const {
    const double free = free_length(angle);
    const double fallen = below + radius * std::sin(angle) + free * std::cos(angle);
    return 2 * kGravity * fallen / free + kGravity * std::cos(angle);
  }

  bool stays_taut() const {
    for (double angle = 0; angle < 1.5 * pi; angle += 1e-3) {
      if (tension(angle) < 0) return false;
    }
    return true;
  }

  /// By how much (m) the weight comes nearer to the peg than a taut string keeps it.
  double most_slack() const {
    World world;
    Connector string = straight_connector("string", 1, 1e-3, 101, Vec3::Zero(), Vec3::UnitX());
    string.particle_mass.back() += 1;
    string.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
    const Vec3 peg(-radius, -below, 0);
    world.connectors = {string};
    world.obstacles = {post(radius, peg)};
    finish(world);
    Simulation simulation = by_direct(world, 1e-3);
    double most = 0;
    for (double time = 0.65; time < 1.2; time += 0.005) {  // straight down at 0.59 s
      simulation.advance_to(time);
      const Vec3 from = simulation.world().connectors[0].position.back() - peg;
      double angle = -std::atan2(from.y(), from.x()) - std::acos(radius / from.norm());
      if (angle < 0) angle += 2 * pi;
      if (angle > 1.4 * pi) break;
      const double apart = std::sqrt(from.squaredNorm() - radius * radius);
      most = std::max(most, free_length(angle) - apart);
    }
    return most;
  }
};

// Without a radius the string stays taut from 3/5 of its length on.
TEST(ContactAnswers, AWeightLoopsAPegJustWhereItMust) {
  double slack = 0.4, taut = 0.8;
  for (int i = 0; i < 40; ++i) {
    const double middle = (slack + taut) / 2;
    (Galileo{.below = middle}.stays_taut() ? taut : slack) = middle;
  }
  // The string's own mass, a thousandth, shifts that by about as much of a length.
  EXPECT_GT(Galileo{.below = taut - 0.005}.most_slack(), 1e-3);
  EXPECT_LT(Galileo{.below = taut + 0.005}.most_slack(), 1e-4);
  EXPECT_NEAR((Galileo{.radius = 1e-9, .below = 0.6 + 1e-6}.tension(pi)), 0, 1e-3);
}

/// The looping pendulum with a massless cord (arXiv 2103.14752): the light weight, at a free length
/// and an angle below the horizontal, and how far and how fast the heavy one has sunk.
struct LoopingPendulum {
  double light = 0.03, heavy = 0.42, friction = 0.25, radius = 0.03;
  std::array<double, 5> state{};  // length, angle, its rate, sunk, its rate
  bool stopped = false;

  std::array<double, 5> rates(const std::array<double, 5>& at) const {
    const auto& [length, angle, rate, sunk, sinking] = at;
    const double holds = light / heavy * std::exp(friction * (pi / 2 + angle));
    const double pull = length * rate * rate + kGravity * std::sin(angle);
    const double faster = stopped ? 0 : (kGravity - holds * pull) / (1 + holds);
    return {-radius * rate - sinking, rate,
            (kGravity * std::cos(angle) + radius * rate * rate + 2 * sinking * rate) / length,
            sinking, faster};
  }

  /// The classical method of order four.
  void step(double h) {
    const auto plus = [&](const std::array<double, 5>& slope, double time) {
      std::array<double, 5> to = state;
      for (std::size_t i = 0; i < to.size(); ++i) to[i] += time * slope[i];
      return to;
    };
    const auto a = rates(state), b = rates(plus(a, h / 2)), c = rates(plus(b, h / 2));
    const auto d = rates(plus(c, h));
    for (std::size_t i = 0; i < state.size(); ++i) {
      state[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
    }
    if (state[4] <= 0 && state[3] > 0) {
      stopped = true;
      state[4] = 0;
    }
  }

  Vec3 light_place() const {
    const double angle = state[1];
    const Vec3 along(std::cos(angle), -std::sin(angle), 0);
    return radius * Vec3(std::sin(angle), std::cos(angle), 0) + state[0] * along;
  }
};

// The cord has a three hundredth of the light weight's mass, and a chord bends it by 11 degrees:
// both are felt where it winds up fast.
TEST(ContactAnswers, ALightWeightSavesAHeavyOne) {
  LoopingPendulum pendulum;
  constexpr std::size_t arc = 16, before = 45, links = 170;
  const double link = 2 * pendulum.radius * std::sin(pi / arc / 2);
  const double length = link * links;
  Connector cord = straight_connector("cord", length, 1e-4, links + 1, Vec3::Zero(), Vec3::UnitX());
  for (std::size_t i = 0; i <= links; ++i) {
    const double n = static_cast<double>(i) - before;
    const double angle = pi - pi / arc * n;
    cord.position[i] = n < 0 ? Vec3(-pendulum.radius, link * n, 0)
                       : n <= arc / 2
                           ? Vec3(pendulum.radius * Vec3(std::cos(angle), std::sin(angle), 0))
                           : Vec3(link * (n - arc / 2), pendulum.radius, 0);
  }
  cord.particle_mass.front() += pendulum.heavy;
  cord.particle_mass.back() += pendulum.light;
  World world;
  world.connectors = {cord};
  world.obstacles = {post(pendulum.radius, Vec3::Zero(), pendulum.friction)};
  finish(world);
  Simulation simulation = by_direct(world, 1e-3);
  pendulum.state[0] = link * static_cast<double>(links - before - arc / 2);
  const double start = cord.position.front().y();
  for (int k = 1; k <= 42; ++k) {
    for (int i = 0; i < 1000; ++i) pendulum.step(1e-5);
    const double time = 0.01 * k;
    if (pendulum.state[0] < 0.1) break;
    simulation.advance_to(time);
    const auto& at = simulation.world().connectors[0].position;
    const double allowed = time < 0.3 ? 5e-4 : 2e-3;
    EXPECT_LT((at.back() - pendulum.light_place()).norm(), allowed * length) << time;
    EXPECT_NEAR(start - at.front().y(), pendulum.state[3], allowed * length) << time;
  }
  EXPECT_TRUE(pendulum.stopped);
  EXPECT_LT(simulation.world().connectors[0].velocity.front().norm(), 0.05);  // from 2.1 m/s
}

// A chain slips off a smooth peg, whatever its radius: the momenta of what hangs leave the peg
// g (L - 4 (2 x^2 - x0^2)/L) of a mass per length, which is nothing at L/sqrt(8), from rest at
// x0 = 0. The chain of links presses as its chords come and go, which fades with their length.
TEST(ContactAnswers, APegIsPressedNoMoreAtTheEighthRoot) {
  double crossing[2];
  for (const std::size_t fine : {1, 2}) {
    const std::size_t each = 40 * fine;
    const World world = over_post(12 * fine, 0, each - 2 * fine, each + 2 * fine,
                                  0.01 / static_cast<double>(fine), 1, 0);
    const double length = world.connectors[0].length, first = 0.02;
    const double rate = std::sqrt(2 * kGravity / length);
    Simulation simulation = by_direct(world, 1e-5);
    const auto momentum = [&] {
      double sum = 0;
      const Connector& chain = simulation.world().connectors[0];
      for (std::size_t i = 0; i < chain.particles(); ++i) {
        sum += chain.particle_mass[i] * chain.velocity[i].y();
      }
      return sum;
    };
    const double from = std::acosh(0.10 * length / first) / rate;
    const double until = std::acosh(0.28 * length / first) / rate;
    simulation.advance_to(from);
    double before = momentum(), last = from;
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    Eigen::Vector2d sums = Eigen::Vector2d::Zero();
    for (int k = 1; k <= 40; ++k) {  // a straight line through force against x^2
      const double time = from + (until - from) * k / 40;
      simulation.advance_to(time);
      const double force = (momentum() - before) / (time - last) + kGravity;
      const double x = first * std::cosh(rate * (time + last) / 2);
      const Eigen::Vector2d row(1, x * x - first * first / 2);
      squares += row * row.transpose();
      sums += force * row;
      before = momentum();
      last = time;
    }
    const Eigen::Vector2d line = squares.inverse() * sums;
    crossing[fine - 1] = std::sqrt(-line[0] / line[1]) / length;
  }
  const double known = 1 / std::sqrt(8.0);
  EXPECT_NEAR(crossing[0], known, 0.02);
  EXPECT_LT(std::abs(crossing[1] - known), 0.6 * std::abs(crossing[0] - known));
  EXPECT_NEAR(2 * crossing[1] - crossing[0], known, 2e-3);
}

}  // namespace
}  // namespace taut::contact_answers_test
