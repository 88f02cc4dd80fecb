// Links that only pull: what is known of them beforehand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "contact_worlds.h"
#include "sim/measure/measure.h"
#include "sim/truth/truth.h"
#include "tests/support/dice.h"

namespace taut::strings_test {
namespace {

using namespace contact_worlds;
using worlds::kGravity;

constexpr double kRounding = 1e-10;

Settings settings_of(const std::string& method) {
  if (method == "direct") return {{"tolerance", 1e-5}};
  if (method == "xpbd") return {{"step", 1.0 / 3840}};
  if (method == "springs") return {{"stiffness", 1e6}, {"damping", 1.0}};
  return {};
}

Simulation by(const std::string& method, const World& world) {
  return {world, make_method(method, settings_of(method))};
}

World with_strings(World world) {
  for (Connector& connector : world.connectors) connector.pulls = true;
  world.topology = structure(world);
  return world;
}

/// A bead on a string of a metre, at rest so many degrees above the horizontal.
World above_the_horizontal(double degrees) {
  return with_strings(worlds::pendulum(1, 90 + degrees));
}

// The bead falls freely until the string is taut again, as far below the horizontal as it was
// above. Then only the speed across the string is left, whose energy it keeps.
class StringPendulum : public testing::TestWithParam<const char*> {
 protected:
  const double angle_ = std::numbers::pi / 3;
  const double taut_ = 2 * std::sqrt(std::sin(angle_) / kGravity);  // s
  const double speed_ = kGravity * taut_ * std::cos(angle_);        // m/s, as it swings off

  /// By the pendulum's equation, from there on; Runge-Kutta's error is below 1e-12.
  Vec3 swung(double time) const {
    double at = std::numbers::pi / 2 - angle_,
           turns = -speed_;  // from straight down, rad and rad/s
    constexpr int kSteps = 2000;
    const double h = (time - taut_) / kSteps;
    const auto slope = [](double a) { return -kGravity * std::sin(a); };
    for (int i = 0; i < kSteps; ++i) {
      const double a1 = slope(at), w2 = turns + h / 2 * a1, a2 = slope(at + h / 2 * turns);
      const double w3 = turns + h / 2 * a2, a3 = slope(at + h / 2 * w2);
      const double w4 = turns + h * a3, a4 = slope(at + h * w3);
      at += h / 6 * (turns + 2 * w2 + 2 * w3 + w4);
      turns += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    return Vec3(std::sin(at), -std::cos(at), 0);
  }

  /// m: of the first-order methods what they move in a few steps, a thousandth of a second.
  double tolerance() const {
    const std::string method = GetParam();
    if (method == "truth") return 1e-9;
    return method == "direct" ? 3e-5 : 5e-3;
  }
};

TEST_P(StringPendulum, FallsFreelyUntilTautAndSwings) {
  Simulation simulation = by(GetParam(), above_the_horizontal(60));
  const double l = 1, across = l * std::cos(angle_), above = l * std::sin(angle_);
  for (int frame = 1; frame <= 60; ++frame) {
    const double time = frame / 60.0;
    simulation.advance_to(time);
    const Vec3 at = simulation.world().connectors[0].position[1];
    if (time < taut_) {
      // Methods of first order fall short by half a step's fall.
      const Vec3 falls(across, above - kGravity * time * time / 2, 0);
      EXPECT_LE((at - falls).norm(), tolerance()) << time;
    } else if (time > taut_ + 1.0 / 60) {
      EXPECT_LE((at - swung(time)).norm(), tolerance()) << time;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, StringPendulum,
                         testing::Values("truth", "direct", "xpbd", "springs"));

// 2 m g l sin^3 of the angle.
TEST(Strings, LoseWhatGoesAlongThemWhenTaut) {
  for (const char* method : {"truth", "direct"}) {
    for (const double degrees : {10.0, 45.0, 80.0}) {
      const World world = above_the_horizontal(degrees);
      Simulation simulation = by(method, world);
      const double sine = std::sin(degrees * std::numbers::pi / 180);
      simulation.advance_to(2 * std::sqrt(sine / kGravity) + 0.05);
      const double mass = world.connectors[0].particle_mass[1];
      EXPECT_NEAR(energy(world) - energy(simulation.world()),
                  2 * mass * kGravity * std::pow(sine, 3), 1e-4 * mass * kGravity)
          << method << " " << degrees;
    }
  }
}

/// A string of beads in space, shorter than its links from bead to bead, which fly apart.
World scattered(unsigned seed, std::size_t particles) {
  Dice dice(seed);
  World world;
  world.gravity.setZero();
  Connector string = straight_connector("string", 1, 0.5, particles, Vec3::Zero(), Vec3::UnitX());
  for (std::size_t i = 0; i < particles; ++i) {
    string.position[i] *= 0.8;
    string.velocity[i] = dice.within(2);
    string.particle_mass[i] *= dice.scale(0.3, 3);
  }
  string.pulls = true;
  world.connectors = {string};
  finish(world);
  return world;
}

// Of two beads exactly: the reduced mass times half the square of the speed at which they part.
TEST(Strings, StopTwoBeadsAsAPlasticImpactDoes) {
  for (const char* method : {"truth", "direct"}) {
    World world = scattered(3, 2);
    Connector& pair = world.connectors[0];
    pair.velocity = {Vec3(-1, 0, 0), Vec3(0.5, 0, 0)};
    const double m0 = pair.particle_mass[0], m1 = pair.particle_mass[1];
    Simulation simulation = by(method, world);
    simulation.advance_to(0.5);
    EXPECT_NEAR(energy(world) - energy(simulation.world()), m0 * m1 / (m0 + m1) * 1.5 * 1.5 / 2,
                1e-9)
        << method;
  }
}

// Momenta pass from bead to bead, however many strings snap. The truth keeps them as well as each
// of its thousands of steps keeps its local error, 1e-12; `direct` as well as its tolerance asks.
TEST(Strings, KeepMomentaAndNeverGainEnergy) {
  for (const char* method : {"truth", "direct"}) {
    const double kept = std::string_view(method) == "truth" ? 1e-8 : 1e-6;
    for (unsigned seed = 0; seed < 12; ++seed) {
      const World world = scattered(seed, 2 + seed);
      Simulation simulation = by(method, world);
      const Vec3 linear = linear_momentum(world), angular = angular_momentum(world, Vec3::Zero());
      double before = energy(world);
      for (int frame = 1; frame <= 60; ++frame) {
        simulation.advance_to(frame / 60.0);
        const World& now = simulation.world();
        EXPECT_LE((linear_momentum(now) - linear).norm(), kept) << method << " " << seed;
        EXPECT_LE((angular_momentum(now, Vec3::Zero()) - angular).norm(), kept)
            << method << " " << seed;
        EXPECT_LE(energy(now), before + 1e-5 * energy(world)) << method << " " << seed;
        EXPECT_LE(stretch_max(now), kRounding) << method << " " << seed;
        before = energy(now);
      }
      EXPECT_LT(before, 0.99 * energy(world)) << "some string snaps";
    }
  }
}

// Two free bodies that a string of many beads catches: a slack one at the start.
TEST(Strings, CatchBodies) {
  World world;
  world.gravity.setZero();
  const Vec3 point(0.02, 0.1, 0.03);
  Connector string = straight_connector("string", 1, 0.1, 6, Vec3::Zero(), Vec3::UnitX());
  for (Vec3& at : string.position) at *= 0.7;
  Body a = worlds::box("a"), b = worlds::box("b");
  a.spin.setZero(), b.spin.setZero();
  a.position = string.position.front() - point;
  b.position = string.position.back() - point;
  a.velocity = Vec3(-1, 0.2, 0), b.velocity = Vec3(1, 0, 0.3);
  world.bodies = {a, b};
  string.holds = {{0, worlds::on_body(0, point)}, {5, worlds::on_body(1, point)}};
  string.pulls = true;
  world.connectors = {string};
  finish(world);
  Simulation simulation = by("direct", world);
  const Vec3 linear = linear_momentum(world);
  double before = energy(world);
  for (int frame = 1; frame <= 60; ++frame) {
    simulation.advance_to(frame / 60.0);
    EXPECT_LE((linear_momentum(simulation.world()) - linear).norm(), kRounding);
    EXPECT_LE(stretch_max(simulation.world()), kRounding);
    before = energy(simulation.world());
  }
  EXPECT_LT(before, 0.99 * energy(world));
}

/// Beads straight above each other, the last on a plane.
World above_a_plane(std::size_t particles) {
  World world;
  Connector string = straight_connector("string", 1, 1, particles, Vec3(0, 1, 0), -Vec3::UnitY());
  string.radius = 0;
  string.pulls = true;
  world.connectors = {string};
  world.obstacles = {obstacle(plane_shape())};
  finish(world);
  return world;
}

// A string never pushes, so that no bead knows of those that have landed.
TEST(Strings, LandAsInFreeFall) {
  for (const char* method : {"truth", "direct"}) {
    const World world = above_a_plane(21);
    Simulation simulation = by(method, world);
    for (int frame = 1; frame <= 32; ++frame) {
      const double time = frame / 60.0;
      simulation.advance_to(time);
      for (std::size_t i = 0; i < 21; ++i) {
        const double start = world.connectors[0].position[i].y();
        EXPECT_NEAR(simulation.world().connectors[0].position[i].y(),
                    std::max(0.0, start - kGravity * time * time / 2), 1e-9)
            << method << " bead " << i << " at " << time;
      }
    }
  }
}

/// The force on a plane over the weight of the beads that have landed: as the middle bead lands, on
/// average from one landing to the next.
double press(std::size_t particles) {
  const World world = above_a_plane(particles);
  const std::size_t middle = (particles - 1) / 2;
  const auto lands = [&](std::size_t bead) {
    return std::sqrt(2 * world.connectors[0].position[bead].y() / kGravity);
  };
  const double from = (lands(middle + 1) + lands(middle)) / 2;
  const double until = (lands(middle) + lands(middle - 1)) / 2;
  Simulation simulation = by("direct", world);
  simulation.advance_to(from);
  const double before = linear_momentum(simulation.world()).y();
  simulation.advance_to(until);
  const double gains = (linear_momentum(simulation.world()).y() - before) / (until - from);
  const double bead = 1 / static_cast<double>(particles);
  const double landed = bead * (static_cast<double>(particles - 1 - middle) + 0.5);
  return (gains + kGravity) / (landed * kGravity);
}

// Three times the weight of what lies on it, in the limit of many beads.
TEST(Strings, PressAPlateWithThreeTimesTheirWeight) {
  const double coarse = press(51), fine = press(101);
  EXPECT_LT(std::abs(fine - 3), 0.6 * std::abs(coarse - 3));  // of first order
  EXPECT_NEAR(2 * fine - coarse, 3, 0.01);
}

/// A string that is held at one end, and falls from where it is folded.
World folded(std::size_t particles) {
  World world = worlds::chain(particles, 1, Vec3::UnitX(), 0.1);
  Connector& string = world.connectors[0];
  for (std::size_t i = 1; i < particles; ++i) {
    const double along = static_cast<double>(i) / static_cast<double>(particles - 1);
    string.position[i] = Vec3(0.6 * along, 0.2 * std::sin(3 * along), 0.1 * along * along);
  }
  return with_strings(world);
}

// A string flies along itself. A pin stops what is ahead of it, at that moment, and nothing else.
TEST(Strings, AreStoppedByAPinAtItsMoment) {
  World world = with_strings(worlds::chain(2, 1, Vec3::UnitX(), 0.1));
  Connector& string = world.connectors[0];
  string.holds.clear();
  for (Vec3& velocity : string.velocity) velocity = Vec3::UnitX();
  world.gravity.setZero();
  for (const std::string method : {"truth", "direct"}) {
    Simulation simulation = by(method, world);
    simulation.advance_to(0.1);
    ASSERT_EQ(simulation.interventions().pin(simulation.world(), 0, 0.5).outcome, Outcome::done);
    simulation.advance_to(0.2);
    const Connector& now = simulation.world().connectors[0];
    EXPECT_LT((now.position[0] - Vec3(0.2, 0, 0)).norm(), 1e-8) << method;
    EXPECT_LT((now.position[2] - Vec3(1.1, 0, 0)).norm(), 1e-7) << method;
  }
}

// A string of rubber: free fall while it is slack, then half a swing of m x'' = m g - k x, and free
// flight upwards again, to where it came from.
TEST(Strings, ThatStretchPushNothing) {
  constexpr double kStiffness = 400, kMass = 2, kSlack = 0.5;  // N/m, kg, m
  World world;
  Connector rubber = straight_connector("rubber", 1, 2e-9, 2, Vec3::Zero(), -Vec3::UnitY());
  rubber.pulls = true;
  Section section;
  section.axial_stiffness = kStiffness;
  rubber.sections.assign(1, section);
  rubber.particle_mass[1] = kMass;
  rubber.position[1] = Vec3(0, kSlack - 1, 0);
  rubber.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
  world.connectors = {rubber};
  const double falls = std::sqrt(2 * kSlack / worlds::kGravity);  // s
  const double speed = worlds::kGravity * falls, rate = std::sqrt(kStiffness / kMass);
  const double rests = worlds::kGravity / (rate * rate);  // m
  const double turns = (std::numbers::pi - std::atan(speed / rate / rests)) / rate;
  const double lowest = 1 + rests + std::hypot(rests, speed / rate);
  for (const auto& [method, key, value, error] : {std::tuple{"direct", "tolerance", 1e-6, 2e-6},
                                                  {"direct", "step", 1e-3, 2e-3},
                                                  {"xpbd", "step", 1e-5, 2e-3},
                                                  {"springs", "step", 1e-5, 2e-4}}) {
    Simulation simulation(world, make_method(method, {{key, value}}));
    const auto height = [&](double time) {
      simulation.advance_to(time);
      return simulation.world().connectors[0].position[1].y();
    };
    EXPECT_NEAR(height(0.8 * falls), kSlack - 1 - 0.64 * kSlack, error) << method;
    EXPECT_NEAR(height(falls + turns), -lowest, error) << method;
    EXPECT_NEAR(height(2 * (falls + turns)), kSlack - 1, 2 * error) << method;
    EXPECT_NEAR(elastic_energy(simulation.world()), 0, 1e-12) << "slack";
  }
}

// Of light particles, which rattle between their links, no energy comes.
TEST(Strings, ThatStretchGainNoEnergy) {
  for (const std::size_t particles : {3, 6, 16}) {
    for (const double stiffness : {50.0, 1e4, 1e6}) {
      World world;
      Connector rubber =
          straight_connector("rubber", 1, 0.05, particles, Vec3::Zero(), -Vec3::UnitY());
      for (Vec3& at : rubber.position) at *= 0.8;
      rubber.pulls = true;
      Section section;
      section.axial_stiffness = stiffness;
      rubber.sections.assign(rubber.links(), section);
      rubber.particle_mass.back() = 1;
      rubber.holds = {{0, worlds::fixed_at(Vec3::Zero())}};
      world.connectors = {rubber};
      world.topology = structure(world);
      Simulation simulation(world, make_method("direct", {{"tolerance", 1e-3}}));
      const double start = energy(simulation.world());
      for (int frame = 1; frame <= 12; ++frame) {
        simulation.advance_to(0.05 * frame);
        EXPECT_LT(energy(simulation.world()), start + 0.01) << particles << ' ' << stiffness;
      }
    }
  }
}

// A weight falls 1.95 m, past the place that its string is fixed to. One string takes what goes
// along it; one of five light particles gives it back.
// But for damping that is critical for the weight on the string.
TEST(Strings, OfSeveralLightParticlesThrowAWeightBack) {
  struct Case {
    std::size_t particles = 0;
    bool damped = false;
  };
  for (const auto& [particles, damped] : {Case{2, false}, Case{6, false}, Case{6, true}}) {
    World world = with_strings(worlds::chain(particles, 1, Vec3(0.3, 1, 0).normalized(), 1e-3));
    Connector& string = world.connectors[0];
    string.particle_mass.back() = 1;
    if (damped) {
      constexpr double kStiffness = 2000;  // N
      string.sections.assign(string.links(), {.axial_stiffness = kStiffness,
                                              .axial_damping = 2 * std::sqrt(kStiffness)});
    }
    finish(world);
    const double fallen = 1.0 + world.connectors[0].position.back().y();
    Simulation simulation = by("direct", world);
    double nearest = 1;
    for (int frame = 1; frame <= 90; ++frame) {
      simulation.advance_to(0.01 * frame);
      if (frame > 64) {
        nearest = std::min(nearest, simulation.world().connectors[0].position.back().norm());
      }
    }
    const double lost = energy(world) - energy(simulation.world());
    if (damped) {
      EXPECT_GT(nearest, 0.99);
      EXPECT_GT(lost, 0.8 * worlds::kGravity * fallen);
    } else if (particles == 2) {
      EXPECT_NEAR(nearest, 1, 1e-6);
      EXPECT_GT(lost, 0.8 * worlds::kGravity * fallen);
    } else {
      EXPECT_LT(nearest, 0.5);
      EXPECT_LT(lost, 0.02 * worlds::kGravity * fallen);
    }
  }
}

// The time stepping comes to the located events, by a power of two, as steps are halved.
TEST(Strings, TwoSolversAgree) {
  Simulation truth = by("truth", folded(5));
  truth.advance_to(0.4);
  double before = 0;
  for (const double step : {8e-4, 4e-4, 2e-4, 1e-4}) {
    Simulation other(folded(5), make_method("direct", {{"step", step}}));
    other.advance_to(0.4);
    double error = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      error = std::max(
          error, (truth.world().connectors[0].position[i] - other.world().connectors[0].position[i])
                     .norm());
    }
    if (before > 0) {
      EXPECT_LT(error, 0.4 * before) << step;
    }
    before = error;
  }
  EXPECT_LT(before, 1e-6);
}

}  // namespace
}  // namespace taut::strings_test
