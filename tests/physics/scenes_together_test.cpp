// The scenes in which features stand together, against laws that everybody can check.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/load/load_scene.h"
#include "sim/measure/measure.h"
#include "sim/run/forces.h"
#include "worlds.h"

namespace taut::scenes_together_test {
namespace {

using std::numbers::pi;
using worlds::kGravity;
using worlds::total_mass;

scenes::Scene scene(const std::string& name) {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/together/" + name + ".toml", false);
}

/// Of holds and obstacles.
Vec3 from_outside(const Forces& forces) {
  Vec3 sum = Vec3::Zero();
  for (const Forces::Hold& hold : forces.holds) sum += hold.force;
  for (const Forces::Contact& contact : forces.contacts) {
    if (contact.other.kind == Forces::Side::Kind::obstacle) sum += contact.force;
  }
  return sum;
}

// Of three hoses the stiff one comes to rest: its hump, and how far its tip sinks.
TEST(HoseOverEdge, AStiffOneLiftsOffBehindTheEdge) {
  scenes::Scene hoses = scene("hose_over_edge");
  hoses.world.connectors.resize(1);
  Simulation simulation = scenes::start(hoses);
  simulation.advance_to(2);
  const Connector& hose = simulation.world().connectors[0];
  constexpr double kOver = 0.6, kTop = 0.812;  // m
  const double weight = 0.32 * kGravity / 1.6, stiffness = hose.sections[0].bending_stiffness;
  double highest = kTop;
  for (const Vec3& at : hose.position) highest = std::max(highest, at.y());
  const double hump = 27.0 / 6144 * weight * std::pow(std::sqrt(2) * kOver, 4) / stiffness;
  EXPECT_NEAR(highest - kTop, hump, 0.1 * hump);
  const double sinks = 0.24285 * weight * std::pow(kOver, 4) / stiffness;
  EXPECT_NEAR(kTop - hose.position.back().y(), sinks, 0.1 * sinks);
}

// The others slide off: mu (1 - f) exp(mu pi/2) is less than the share f over the edge.
TEST(HoseOverEdge, ALimpOneSlidesOff) {
  scenes::Scene hoses = scene("hose_over_edge");
  hoses.world.connectors.erase(hoses.world.connectors.begin(), hoses.world.connectors.begin() + 2);
  Simulation simulation = scenes::start(hoses);
  simulation.advance_to(0.8);
  EXPECT_GT(simulation.world().connectors[0].position[0].x(), -0.9);
}

// A cord of 20 g takes little of the energy of 2 kg.
TEST(BungeeFloor, TheBallBouncesAsItsEnergySays) {
  const scenes::Scene bungee = scene("bungee_floor");
  Simulation simulation = scenes::start(bungee);
  double before = 0, after = 0, stretch = 0;
  for (int frame = 1; frame <= 120 && after <= 0; ++frame) {
    simulation.advance_to(0.01 * frame);
    for (const Event& event : simulation.take_events()) {
      if (event.kind == Event::Kind::hit && after <= 0) after = event.size;
    }
    const Body& ball = simulation.world().bodies[0];
    if (after <= 0) {
      before = -ball.velocity.y();
      stretch = (ball.position + 0.1 * Vec3::UnitY() - Vec3(0, 2.4, 0)).norm() - 1;
    }
  }
  const double fall = 2.4 - 0.1;  // m, of the ball's centre to where it touches
  const double apart = std::hypot(0.3, 2.2) - 1;
  const double speed = std::sqrt(2 * kGravity * fall - 40 / 2.0 * apart * apart);
  EXPECT_GT(stretch, 0.9 * apart);
  EXPECT_NEAR(before, speed, 0.06 * speed);
  EXPECT_NEAR(after, 2 * 1.8 * speed, 0.06 * 2 * 1.8 * speed);  // N s
}

// The drum slips in the whole of its turn and a half.
TEST(LongCableDrum, FrictionMultipliesTheWinchsPull) {
  scenes::Scene drum = scene("cable_drum");
  Simulation simulation = scenes::start(drum);
  constexpr double kFriction = 0.3, kRadius = 0.106, kTurn = 3 * pi, kStiffness = 0.02;
  double pull = 0, load = 0;
  int times = 0;
  for (int frame = 48; frame <= 75; ++frame, ++times) {  // the load oscillates
    simulation.advance_to(frame / 60.0);
    const Forces forces = forces_of(simulation.world());
    pull += forces.links.front().tension;
    load += forces.links.back().tension;
  }
  pull /= times;
  load /= times;
  EXPECT_NEAR(load, 12 * kGravity, 0.05 * 12 * kGravity);
  const auto off = [&](double tension) {
    return std::acos(1 - kStiffness / (2 * tension * kRadius * kRadius));
  };
  const double a0 = off(pull), a1 = off(load);
  const double held =
      pull * (std::cos(a0) + kFriction * std::sin(a0)) * std::exp(kFriction * (kTurn - a0 - a1));
  EXPECT_NEAR(load * (std::cos(a1) - kFriction * std::sin(a1)), held, 0.1 * held);
}

TEST(NetOnBall, TheFloorBearsBoth) {
  const scenes::Scene net = scene("net_on_ball");
  Simulation simulation = scenes::start(net);
  simulation.advance_to(1);
  const World& world = simulation.world();
  const double weight = total_mass(world) * kGravity;
  EXPECT_NEAR(weight, 1.9 * kGravity, 1e-6);
  EXPECT_LT((from_outside(forces_of(world)) - weight * Vec3::UnitY()).norm(), 0.02 * weight);
}

// The belt slips on the wheel that stands, which it leaves with the larger tension.
TEST(LongBelt, EulersFactorBetweenItsSpans) {
  const scenes::Scene belt = scene("belt");
  Simulation simulation = scenes::start(belt);
  double upper = 0, lower = 0;  // N
  for (int frame = 60; frame <= 72; ++frame) {
    simulation.advance_to(frame / 60.0);
    const Connector& cord = simulation.world().connectors[0];
    double above = 0, below = 0;
    for (const Forces::Link& link : forces_of(simulation.world()).links) {
      if (std::abs(link.place.x() - 0.5) > 0.3) continue;
      // What runs round a wheel presses less on it.
      const double speed = cord.velocity[link.link].norm();
      const double left = link.tension - cord.mass / cord.length * speed * speed;
      (link.place.y() > 1 ? upper : lower) += left;
      (link.place.y() > 1 ? above : below) += 1;
    }
    EXPECT_GT(std::min(above, below), 20);
  }
  const double factor = std::max(upper, lower) / std::min(upper, lower);
  EXPECT_NEAR(factor, std::exp(0.2 * pi), 0.05 * std::exp(0.2 * pi));
}

TEST(CraneTouchdown, TheCraneBearsHalfOfWhatIsOffTheFloor) {
  const scenes::Scene crane = scene("crane_touchdown");
  Simulation simulation = scenes::start(crane);
  simulation.advance_to(2.5);
  const double weight = 1.5 * kGravity / 3;  // N/m
  const double off = std::pow(24 * 3.0 * 0.12 / weight, 0.25);
  const double rope = 0.02 * kGravity * 0.88;
  const Forces forces = forces_of(simulation.world());
  ASSERT_EQ(forces.holds.size(), 1u);
  EXPECT_NEAR(forces.holds[0].force.y(), weight * off / 2 + rope, 0.05 * weight * off / 2);
  simulation.advance_to(4);  // let down again, the floor bears all but the rope
  EXPECT_LT(forces_of(simulation.world()).holds[0].force.y(), 0.1 * weight * off);
}

TEST(ClampedStick, TheCentreOfMassFliesAlongParabolas) {
  const scenes::Scene stick = scene("clamped_stick");
  Simulation simulation = scenes::start(stick);
  const auto momentum = [&] { return linear_momentum(simulation.world()); };
  int flights = 0;
  Vec3 last = momentum();
  for (int frame = 1; frame <= 180; ++frame) {  // until the rod touches, too
    simulation.advance_to(0.005 * frame);
    const bool hit = !simulation.take_events().empty();
    const Vec3 now = momentum();
    if (!hit) {
      const Vec3 change = -0.005 * kGravity * total_mass(simulation.world()) * Vec3::UnitY();
      EXPECT_LT((now - last - change).norm(), 1e-3 * change.norm()) << frame;
      ++flights;
    }
    last = now;
  }
  EXPECT_GT(flights, 100);
  EXPECT_LT(flights, 180);
}

/// What is missing (N) for what is from outside to change the momentum as it changes.
double out_of_balance(Simulation& simulation, double time, const Vec3& drag) {
  constexpr double kApart = 1e-3;  // s
  simulation.advance_to(time - kApart);
  const Vec3 before = linear_momentum(simulation.world());
  simulation.advance_to(time);
  const Vec3 outside = from_outside(forces_of(simulation.world())) + drag +
                       total_mass(simulation.world()) * simulation.world().gravity;
  simulation.advance_to(time + kApart);
  return (outside - (linear_momentum(simulation.world()) - before) / (2 * kApart)).norm();
}

TEST(RopeBridge, ItsEndsBearTheBallAndTheBridge) {
  scenes::Scene bridge = scene("rope_bridge");
  bridge.world.air.density = 0;
  Simulation simulation = scenes::start(bridge);
  const double weight = 2.2 * kGravity;
  for (const double time : {0.9, 1.4}) {
    EXPECT_LT(out_of_balance(simulation, time, Vec3::Zero()), 0.1 * weight) << time;
  }
  EXPECT_NEAR(total_mass(simulation.world()), 2.2, 1e-9);
}

/// Of the air on all links, by their middles: Taylor's law of flow across and along.
Vec3 drag_of(const World& world) {
  Vec3 sum = Vec3::Zero();
  for (const Connector& cord : world.connectors) {
    for (std::size_t k = 0; k < cord.links(); ++k) {
      const Vec3 edge = cord.position[k + 1] - cord.position[k], along = edge.normalized();
      const Vec3 speed = world.air.wind - (cord.velocity[k + 1] + cord.velocity[k]) / 2;
      const Vec3 with = speed.dot(along) * along, across = speed - with;
      sum += world.air.density / 2 * cord.sections[k].diameter * edge.norm() *
             (cord.drag.across * across.norm() * across + cord.drag.along * with.norm() * with);
    }
  }
  return sum;
}

TEST(Flag, ThePoleBearsWeightAndDrag) {
  const scenes::Scene flag = scene("flag");
  Simulation simulation = scenes::start(flag);
  simulation.advance_to(1);
  const World& world = simulation.world();
  const Vec3 drag = drag_of(world);
  EXPECT_GT(drag.norm(), total_mass(world) * kGravity / 4);
  EXPECT_LT(out_of_balance(simulation, 1.01, drag), 0.05 * drag.norm());
}

// At their own settings; `direct` keeps a millimetre.
TEST(ScenesTogether, GamesMethodsFollowThem) {
  struct Case {
    std::string scene;
    std::vector<std::string> methods = {"xpbd"};
  };
  const std::vector<Case> cases{{"hose_over_edge", {}},
                                {"cable_drum", {}},
                                {"net_on_ball", {}},
                                {"rope_bridge", {}},
                                {"belt"},
                                {"clamped_stick"},
                                {"bungee_floor", {"xpbd", "springs"}},
                                {"crane_touchdown", {"xpbd", "springs"}},
                                {"flag", {"xpbd", "springs"}}};
  for (const Case& each : cases) {
    const scenes::Scene start = scene(each.scene);
    for (const char* method : {"xpbd", "springs"})
      EXPECT_EQ(refusal(*find_method(method), start.world), "") << each.scene;
    if (each.methods.empty()) continue;
    constexpr double kTime = 0.3;  // s
    Simulation exact = scenes::start(start);
    exact.advance_to(kTime);
    for (const std::string& method : each.methods) {
      Simulation games(start.world, make_method(method, {}), start.timeline);
      games.advance_to(kTime);
      for (std::size_t c = 0; c < start.world.connectors.size(); ++c) {
        const Connector& there = exact.world().connectors[c];
        for (std::size_t p = 0; p < there.particles(); ++p) {
          EXPECT_LT((games.world().connectors[c].position[p] - there.position[p]).norm(), 0.02)
              << method << ", " << each.scene << ", particle " << p;
        }
      }
    }
  }
}

}  // namespace
}  // namespace taut::scenes_together_test
