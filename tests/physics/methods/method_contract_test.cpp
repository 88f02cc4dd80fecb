// One contract for every method: each check reaches a number, and theory says how large it may be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>

#include "contract.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "tests/physics/worlds.h"

namespace taut::method_contract_test {
namespace {

using contract::Exemption;
using contract::Knob;
using contract::Rest;
using contract::Theory;
using worlds::kGravity;

constexpr double kRounding = 1e-11;  // relative, after some thousand steps
constexpr double kSolved = 1e-9;     // m; what a converged solution may be off
constexpr double kHorizon = 0.4;     // s; all the worlds are predictable for so long

class MethodContract : public testing::TestWithParam<Theory> {
 protected:
  void SetUp() override {
    const MethodInfo* method = find_method(theory().method);
    ASSERT_NE(method, nullptr);
    if (!method->missing.empty()) GTEST_SKIP() << method->missing;
  }
  const Theory& theory() const { return GetParam(); }

  World after(const World& start, double time, const Knob& knob, int refined) const {
    Settings settings = theory().settings;
    settings[std::string(knob.name)] = knob.value(refined);
    Simulation simulation(start, make_method(theory().method, settings), timeline_);
    simulation.advance_to(time);
    return simulation.world();
  }
  World after(const World& start, double time, int refined = 0) const {
    return after(start, time, theory().knob, refined);
  }
  double step(int refined = 0) const { return std::get<double>(theory().knob.value(refined)); }

  const Exemption* exemption(const std::string& check) const {
    const auto& rows = contract::exemptions();
    const auto row = std::ranges::find_if(
        rows, [&](const Exemption& e) { return e.label == theory().label && e.check == check; });
    return row == rows.end() ? nullptr : &*row;
  }

  /// `reached` is at most `allowed`; or the method is exempt, reaches just what the table says, and
  /// would break the rule without the exemption.
  void expect(const std::string& check, double reached, double allowed) const {
    RecordProperty(check, std::to_string(reached));
    const Exemption* row = exemption(check);
    if (!row) {
      EXPECT_LE(reached, allowed) << theory().label << ": " << check;
    } else {
      EXPECT_GT(reached, allowed) << theory().label << " needs no exemption from: " << check;
      EXPECT_NEAR(reached, row->reached, 0.1 * std::abs(row->reached)) << check;
    }
  }

  /// The error goes to zero with the knob: what is left after two refinements is what their
  /// difference foretells, within twice (a step further would change it by 1/(f^p - 1) of that).
  void expect_convergence(const std::string& check, const World& start) const;

  Timeline timeline_;  // what happens meanwhile
};

double distance(const World& a, const World& b) {
  double largest = 0;
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    for (std::size_t i = 0; i < a.connectors[c].particles(); ++i) {
      largest =
          std::max(largest, (a.connectors[c].position[i] - b.connectors[c].position[i]).norm());
    }
  }
  return largest;
}

/// The converged solution: the truth, or what judges the truth itself.
World converged(const World& start, const Theory& theory, const Timeline& timeline) {
  const bool itself = theory.method == "truth";
  Simulation simulation(
      start, itself ? make_method("multibody", {{"accuracy", 1e-10}}) : make_method("truth", {}),
      timeline);
  simulation.advance_to(kHorizon);
  return simulation.world();
}

void MethodContract::expect_convergence(const std::string& check, const World& start) const {
  const Exemption* row = exemption(check);
  if (row && !row->refusal.empty()) {
    try {
      after(start, kHorizon);
      ADD_FAILURE() << theory().label << " needs no exemption from: " << check;
    } catch (const Diverged& error) {
      EXPECT_NE(std::string(error.what()).find(row->refusal), std::string::npos) << error.what();
    }
    return;
  }
  const Knob& knob = theory().convergence();
  const World fine = after(start, kHorizon, knob, 1), finest = after(start, kHorizon, knob, 2);
  const double gain = knob.by < 1 ? 1 / knob.by : knob.by;
  const double left = distance(fine, finest) / (std::pow(gain, knob.order) - 1);
  expect(check, distance(finest, converged(start, theory(), timeline_)), 2 * left + kSolved);
}

TEST_P(MethodContract, FreeFlight) {
  World world = worlds::chain(6, 0.5, Vec3(1, 0.3, 0));
  world.connectors[0].holds.clear();
  const Vec3 velocity(1, 2, 3);
  for (Vec3& v : world.connectors[0].velocity) v = velocity;
  const World end = after(world, kHorizon);
  const double fall = -kGravity * kHorizon * (kHorizon / 2 + theory().fall * step());
  double worst = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3 expected =
        world.connectors[0].position[i] + kHorizon * velocity + fall * Vec3::UnitY();
    worst = std::max(worst, (end.connectors[0].position[i] - expected).norm());
  }
  expect("free flight", worst, kRounding);
}

TEST_P(MethodContract, MomentumWithoutOutsideForces) {
  World world = worlds::thrown(6);
  world.gravity.setZero();
  const Vec3 linear = linear_momentum(world), angular = angular_momentum(world);
  const auto change = [&](int refined) {
    const World end = after(world, kHorizon, refined);
    return std::pair((linear_momentum(end) - linear).norm() / linear.norm(),
                     (angular_momentum(end) - angular).norm() / angular.norm());
  };
  const auto coarse = change(0), fine = change(1);
  const double kept = theory().controls_error ? step(1) : kRounding;
  expect("linear momentum kept", fine.first, kept);
  const double falls = std::pow(theory().knob.by, theory().angular);
  const bool exact = theory().angular == 0;
  expect("angular momentum kept", fine.second, exact ? kept : 1.2 * coarse.second / falls);
}

TEST_P(MethodContract, HangingAtRest) {
  constexpr std::size_t links = 10;
  const World world = worlds::chain(links + 1, 1, -Vec3::UnitY());
  double worst = 0;
  for (int frame = 1; frame <= 12; ++frame) {
    worst = std::max(worst, distance(after(world, frame / 24.0), world));
  }
  double allowed = kRounding;
  if (theory().rest == Rest::springy) {
    const double stiffness = 1e4, weight = world.connectors[0].particle_mass[1] * kGravity;
    allowed = 2 * weight * links * (links + 1) / 2 / stiffness;
  } else if (theory().rest == Rest::unfinished) {
    allowed = links * links * kGravity * step() * step();
  }
  expect("hanging at rest", worst, allowed);
}

TEST_P(MethodContract, PendulumPeriod) {
  constexpr double degrees = 90, length = 0.5;
  const World world = worlds::pendulum(length, degrees);
  const double period =
      worlds::period_ratio(degrees) * 2 * std::numbers::pi * std::sqrt(length / kGravity);
  // Back at its start the bead stops and turns, falling with g: its velocity tells how late it is.
  double late[3];
  for (int refined = 0; refined < 3; ++refined) {
    late[refined] = after(world, period, refined).connectors[0].velocity[1].y() / kGravity;
  }
  const double first = late[0] - late[1], second = late[1] - late[2];
  const Knob& knob = theory().knob;
  if (!theory().controls_error && std::abs(first) > kRounding * period) {
    expect("order of the period, short by",
           knob.order - std::log(std::abs(first / second)) / std::log(knob.by), 0.2);
  }
  // The last difference foretells the remaining error; springs lengthen the period, to first order
  // in the stretch m g / k l by softening(), to second by less than its square times a hundred.
  const double left = std::abs(second) / (std::pow(knob.by, knob.order) - 1);
  const bool springy = theory().rest == Rest::springy;
  const double weight = world.connectors[0].particle_mass[1] * kGravity;
  const double stretch = springy ? weight / 1e4 / length : 0;
  const double expected = stretch * worlds::softening(degrees);
  expect("period, relative", std::abs(late[2] / period - expected),
         100 * stretch * stretch + 2 * left / period + kRounding);
}

TEST_P(MethodContract, OrderByStepHalving) {
  if (theory().controls_error) {
    expect_convergence("swing", worlds::chain(6, 0.5, Vec3::UnitX()));
    return;
  }
  const World world = worlds::chain(6, 0.5, Vec3::UnitX());
  const World coarse = after(world, kHorizon, 0), fine = after(world, kHorizon, 1),
              finest = after(world, kHorizon, 2);
  const double ratio = distance(coarse, fine) / distance(fine, finest);
  expect("order on a swing, short by",
         theory().knob.order - std::log(ratio) / std::log(theory().knob.by), 0.3);
}

TEST_P(MethodContract, RigidBodyEnd) {
  expect_convergence("rigid body end", worlds::chain_with_box(6));
}

TEST_P(MethodContract, DrivenEnd) {
  const World world = worlds::driven_chain(6);
  expect_convergence("driven end", world);
  const World end = after(world, kHorizon);
  const PointMotion hand = hold_motion(end, end.connectors[0].holds[0].to, kHorizon);
  EXPECT_EQ(end.connectors[0].position[0], hand.position);
  EXPECT_EQ(end.connectors[0].velocity[0], hand.velocity);
}

TEST_P(MethodContract, TwoFreeBodies) {
  expect_convergence("two free bodies", worlds::thrown(6));
}

TEST_P(MethodContract, SpansAndSeveralConnectors) {
  expect_convergence("pins and several connectors", worlds::garland());
}

// Caught in mid-swing between two of its particles, and let go again: the pin's impulses cost no
// order of convergence.
TEST_P(MethodContract, APinThatComesAndGoes) {
  timeline_.pins = {{0, 0.27, 0.1, 0.2, {}}};
  expect_convergence("a pin that comes and goes", worlds::chain(6, 0.5, worlds::from_down(60)));
}

// A thrown rope that nothing else holds: its free ends swing on about the pin.
TEST_P(MethodContract, APinOnARopeWithoutEnds) {
  World rope = worlds::chain(6, 0.5, Vec3(1, 0.3, 0));
  rope.connectors[0].holds.clear();
  finish(rope);
  for (std::size_t i = 0; i < 6; ++i) {
    rope.connectors[0].velocity[i] =
        Vec3(0.4, 1, 0.2) + Vec3(0.5, -1, 3).cross(rope.connectors[0].position[i]);
  }
  timeline_.pins = {{0, 0.27, 0.1, 0.2, {}}};
  expect_convergence("a pin on a rope without ends", rope);
}

// Drawn aside while it holds: its own acceleration counts.
TEST_P(MethodContract, APinThatIsDrawnAway) {
  const World rope = worlds::chain(6, 0.5, worlds::from_down(60));
  TimedPin pin{0, 0.27, 0.1, 0.35, {}};
  pin.to = worlds::fixed_at(0.27 * worlds::from_down(60) + Vec3(-0.03, 0.02, 0.015));
  pin.over = 0.2;
  timeline_.pins = {pin};
  expect_convergence("a pin that is drawn away", rope);
}

// Swings down onto a floor with friction: no bead ends a step below it, and what comes to lie
// stays. Methods that know no contact say so.
TEST_P(MethodContract, AFloor) {
  World world = worlds::chain(6, 0.5, Vec3::UnitX());
  Obstacle floor;
  floor.name = "floor";
  floor.place.position.y() = -0.3;
  floor.static_friction = floor.kinetic_friction = 0.5;
  world.obstacles = {floor};
  world.topology = structure(world);
  if (!find_method(theory().method)->abilities.follows.has(Feature::obstacle)) {
    try {
      after(world, kHorizon);
      ADD_FAILURE() << theory().label << " says nothing of the floor";
    } catch (const Diverged& error) {
      EXPECT_NE(std::string(error.what()).find("does not follow obstacles (obstacle floor)"),
                std::string::npos)
          << error.what();
    }
    return;
  }
  const World landed = after(world, kHorizon);
  double lowest = 0;
  for (const Vec3& at : landed.connectors[0].position) lowest = std::min(lowest, at.y());
  EXPECT_NEAR(lowest, -0.3, kRounding) << "it reaches the floor and does not enter it";
  EXPECT_EQ(state_hash(landed), state_hash(after(world, kHorizon)));
}

// The beads are thrown together, and the strings between them hold those that fly apart again.
// Methods whose links push say so.
TEST_P(MethodContract, AString) {
  World world = worlds::chain(6, 0.5, Vec3::UnitX());
  for (std::size_t i = 1; i < 6; ++i) {
    world.connectors[0].velocity[i] = Vec3(-1, 0.2 * static_cast<double>(i), 0);
  }
  world.connectors[0].pulls = true;
  world.topology = structure(world);
  if (!find_method(theory().method)->abilities.follows.has(Feature::strings)) {
    try {
      after(world, kHorizon);
      ADD_FAILURE() << theory().label << " says nothing of the string";
    } catch (const Diverged& error) {
      EXPECT_NE(std::string(error.what()).find("does not follow strings (connector chain)"),
                std::string::npos)
          << error.what();
    }
    return;
  }
  const World thrown = after(world, 0.1);
  double shortest = 1;  // of the rest length
  for (std::size_t i = 0; i < 5; ++i) {
    const auto& at = thrown.connectors[0].position;
    shortest = std::min(shortest, (at[i + 1] - at[i]).norm() / thrown.connectors[0].rest[i]);
  }
  EXPECT_LT(shortest, 0.9) << "nothing pushes";
  const World caught = after(world, kHorizon);
  EXPECT_LE(energy(caught), energy(world));
  EXPECT_LT(stretch_max(caught), 0.2) << "of springs: v sqrt(m/k) when a bead is caught";
  EXPECT_EQ(state_hash(caught), state_hash(after(world, kHorizon)));
}

TEST_P(MethodContract, Determinism) {
  const World world = worlds::chain_with_box(6);
  EXPECT_EQ(state_hash(after(world, 0.1)), state_hash(after(world, 0.1)));
  EXPECT_EQ(after(world, 0.1).time, 0.1);
}

INSTANTIATE_TEST_SUITE_P(All, MethodContract, testing::ValuesIn(contract::theories()),
                         [](const auto& row) {
                           std::string name(row.param.label);
                           std::erase_if(name, [](char c) { return !std::isalnum(c); });
                           return name;
                         });

// The table of exemptions in sim/README.md is made of this data.
TEST(MethodContractTable, StandsInTheReadme) {
  std::string table = "| method | does not keep to | reaches | because |\n|---|---|---|---|\n";
  for (const Exemption& row : contract::exemptions()) {
    std::ostringstream line;
    line << "| `" << row.label << "` | " << row.check << " | ";
    if (row.refusal.empty()) {
      line << row.reached << " " << row.unit;
    } else {
      line << "refused: \"" << row.refusal << "\"";
    }
    line << " | " << row.why << " |\n";
    table += line.str();
  }
  std::ifstream file(TAUT_SOURCE_DIR "/sim/README.md");
  const std::string readme(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(readme.find(table), std::string::npos) << "sim/README.md should hold:\n" << table;
}

TEST(MethodContractTable, HoldsEveryMethod) {
  for (const MethodInfo& method : all_methods()) {
    EXPECT_TRUE(std::ranges::any_of(contract::theories(), [&](const Theory& theory) {
      return theory.method == method.name;
    })) << method.name;
  }
}

}  // namespace
}  // namespace taut::method_contract_test
