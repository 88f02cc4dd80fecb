// Every method with every two features of a world: it follows both, or names what it refuses.
#include "sim/features/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>

#include "sim/run/simulation.h"
#include "sim/world/winched.h"
#include "tests/physics/worlds.h"

namespace taut::features_test {
namespace {

constexpr double kUntil = 0.01;  // s

Feature feature(std::size_t index) {
  return static_cast<Feature>(index);
}

std::shared_ptr<const Path> path(const Vec3& by) {
  std::vector<PathKey> keys(2);
  keys[1].time = 1;
  keys[1].position = by;
  for (PathKey& key : keys) key.ease = true;
  return std::make_shared<const Path>(keys);
}

/// A rope that hangs from a fixed place, with room between its ends.
Connector folded(const char* name, const Vec3& from) {
  Connector rope = straight_connector(name, 0.4, 0.1, 5, from, Vec3::UnitX());
  for (std::size_t i = 1; i < 5; ++i) {
    rope.position[i] = rope.position[i - 1] + 0.1 * worlds::from_down(i % 2 == 0 ? -30 : 30);
  }
  rope.holds = {{0, worlds::fixed_at(from)}};
  return rope;
}

/// A small world that uses some features, on one rope as far as that can be.
class Maker {
 public:
  explicit Maker(Features features) : features_(features) {
    Connector rope = folded("rope", Vec3::Zero());
    rope.radius = 0.01;
    world_.connectors = {rope};
    for (std::size_t f = 0; f < kFeatureCount; ++f) {
      if (features.has(feature(f))) add(feature(f));
    }
    // What divides ropes comes last, once masses and holds are known.
    if (!(features & (kReelFeatures | Feature::joint_in_flow)).empty()) add_reels();
    finish(world_);
    if (features.has(Feature::pin)) {
      Interventions interventions;
      EXPECT_EQ(interventions.pin(world_, hand(), 0.25).outcome, Outcome::done);
    }
    if (features.has(Feature::cut)) {
      timeline_.cuts.push_back({.connector = hand(), .along = 0.15, .time = kUntil / 2});
    }
  }

  const World& world() const { return world_; }
  const Timeline& timeline() const { return timeline_; }

 private:
  Connector& rope() { return world_.connectors[0]; }

  void each_section(auto&& change) {
    if (rope().sections.empty()) {
      Section plain;
      plain.diameter = 0.01;
      rope().sections.assign(rope().links(), plain);
    }
    for (std::size_t k = 0; k < rope().links(); ++k) change(rope().sections[k], k);
  }

  std::size_t add_ball(const char* name, const Vec3& at) {
    Body body;
    body.name = name;
    body.mass_properties = solid_sphere(0.2, 0.04);
    body.position = at;
    world_.bodies.push_back(body);
    return world_.bodies.size() - 1;
  }

  std::size_t add_touching_ball(const Vec3& at) {
    const std::size_t ball = add_ball("touching", at);
    world_.bodies[ball].capsule.radius = 0.02;
    return ball;
  }

  /// A body at the rope's end.
  void load() {
    if (rope().holds.size() > 1) return;
    const Vec3 grip(0, 0.02, 0);
    const std::size_t ball = add_ball("load", rope().position.back() - grip);
    rope().holds.push_back({rope().links(), worlds::on_body(ball, grip)});
  }

  Obstacle& floor() {
    if (!world_.obstacles.empty()) return world_.obstacles.front();
    Obstacle& floor = world_.obstacles.emplace_back();
    floor.name = "floor";
    floor.place.position.y() = -1;
    return floor;
  }

  /// A connector that can be pinned and cut: with a winch or pulley it cannot.
  std::size_t hand() {
    if (!rope().winch) return 0;
    return world_.connectors.size() - 1;
  }

  std::size_t add_rope(const char* name, double x) {
    const Connector other = folded(name, Vec3(x, 0, 0));
    world_.connectors.push_back(other);
    return world_.connectors.size() - 1;
  }

  void add(Feature one) {
    switch (one) {
      case Feature::stretch:
        return each_section([](Section& section, std::size_t) { section.axial_stiffness = 1e3; });
      case Feature::rest_curvature:
        each_section([](Section& section, std::size_t) { section.rest_curvature.z() = 1; });
        [[fallthrough]];
      case Feature::bending:
        return each_section([](Section& section, std::size_t) {
          section.bending_stiffness = std::max(section.bending_stiffness, 1e-3);
        });
      case Feature::bending_damping:
        return each_section([](Section& section, std::size_t) { section.bending_damping = 1e-5; });
      case Feature::twist:
        return each_section([](Section& section, std::size_t) {
          section.bending_stiffness = section.twisting_stiffness = 1e-3;
        });
      case Feature::air:
        world_.air.density = 1.2;
        rope().drag.across = 1;
        return each_section([](Section&, std::size_t) {});
      case Feature::taper:
        return each_section([](Section& section, std::size_t k) {
          section.diameter /= static_cast<double>(1 + k);
        });
      case Feature::turning_clamp:
        rope().holds[0].turn = path(Vec3::UnitX());
        [[fallthrough]];
      case Feature::clamp:
        rope().holds[0].clamp = worlds::from_down(30);
        return add(Feature::bending);
      case Feature::clamp_on_body:
        load();
        rope().holds.back().clamp = worlds::from_down(30);
        return add(Feature::bending);
      case Feature::material_on_body:
        load();
        return each_section([](Section&, std::size_t) {});
      case Feature::applied_force:
        rope().applied_force = std::make_shared<const AppliedForce>([](double time, auto place,
                                                                       auto velocity, auto force) {
          for (std::size_t i = 0; i < force.size(); ++i) {
            force[i] += Vec3(0.1 * std::cos(3 * time), 0, 0) - 0.5 * place[i] - 0.02 * velocity[i];
          }
        });
        return;
      case Feature::strings:
        rope().pulls = true;
        return;
      case Feature::string_rebound:
        rope().pulls = true;
        rope().restitution = 0.5;
        return;
      case Feature::obstacle:
        floor();
        return;
      case Feature::moving_obstacle: {
        Obstacle& hand = world_.obstacles.emplace_back();
        hand.name = "hand";
        hand.shape = sphere_shape(0.05);
        hand.place.position.x() = -1;
        hand.path = path(Vec3::UnitY());
        return;
      }
      case Feature::links_touch:
        floor();
        rope().links_touch = true;
        return;
      case Feature::body_contact:
        floor();
        add_touching_ball(Vec3(0.3, -0.8, 0.3));
        return;
      case Feature::body_pairs: {
        const std::size_t a = add_touching_ball(Vec3(-0.3, -0.3, 0.3));
        world_.pairs.push_back({.a = a, .b = add_touching_ball(Vec3(-0.4, -0.3, 0.3))});
        return;
      }
      case Feature::bead_pairs:
        world_.bead_pairs.push_back(
            {.connector = 0, .body = add_touching_ball(Vec3(0.4, -0.3, 0.3))});
        return;
      case Feature::connector_pairs: {
        const std::size_t other = add_rope("neighbour", -0.3);
        world_.connectors[other].radius = rope().radius = 0.005;
        world_.connector_pairs.push_back({0, other});
        return;
      }
      case Feature::self_contact:
        rope().radius = 0.005;
        world_.connector_pairs.push_back({0, 0});
        return;
      case Feature::friction:
        floor().static_friction = floor().kinetic_friction = 0.2;
        return;
      case Feature::restitution:
        floor().restitution = 0.5;
        return;
      case Feature::joint: {
        Connector branch = straight_connector("branch", 0.2, 0.05, 3, rope().position[2],
                                              Vec3(-1, -1, 0).normalized());
        world_.connectors.push_back(branch);
        world_.joints.push_back({{{0, 2}, {world_.connectors.size() - 1, 0}}});
        return;
      }
      case Feature::loop: {
        const std::size_t ring = add_rope("ring", 0.6);
        Connector& connector = world_.connectors[ring];
        const Vec3 corners[] = {{0, 0, 0}, {0, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0, 0}, {0, 0, 0}};
        for (std::size_t i = 0; i < 5; ++i) connector.position[i] = Vec3(0.6, 0, 0) + corners[i];
        world_.joints.push_back({{{ring, 0}, {ring, 4}}});
        return;
      }
      case Feature::joint_in_flow: {
        if (!features_.has(Feature::joint)) add(Feature::joint);
        return;  // with a winch, which add_reels() gives
      }
      case Feature::span: {
        Connector cord = straight_connector("cord", 0.3, 0, 2, Vec3(-0.6, 0, 0), -Vec3::UnitY());
        cord.model = ConnectorModel::span;
        cord.holds = {{0, worlds::fixed_at(Vec3(-0.6, 0, 0))}};
        cord.particle_mass.back() = 0.1;
        world_.connectors.push_back(cord);
        return;
      }
      case Feature::hinge: {
        const Vec3 at(-0.8, 0, 0), grip(0, 0.02, 0);
        Connector hinge = straight_connector("hinge", 0, 0, 2, at, Vec3::UnitY());
        hinge.holds = {{0, worlds::fixed_at(at)},
                       {1, worlds::on_body(add_ball("earring", at - grip), grip)}};
        world_.connectors.push_back(hinge);
        return;
      }
      case Feature::free_body:
        return load();
      default:
        return;  // reels and interventions
    }
  }

  void add_reels() {
    if (!(features_ & kPulleyFeatures).empty()) {
      Connector left = straight_connector("left", 0.3, 0.1, 4, Vec3::Zero(), -Vec3::UnitY());
      std::ranges::reverse(left.position);
      left.holds = {{3, worlds::fixed_at(Vec3::Zero())}};
      world_.connectors.push_back(left);
      rope().mass = 0.1 / 0.3 * rope().length;  // one density on either side
      rope().particle_mass.assign(5, rope().mass / 5);
      add_pulley(world_, "eye", world_.connectors.size() - 1, 0,
                 features_.has(Feature::sheave) ? 0.05 : 0);
      if (features_.has(Feature::pulley_friction)) world_.pulleys[0].friction = 0.1;
    }
    if (features_.has(Feature::winch) || features_.has(Feature::joint_in_flow)) {
      const std::size_t reeled = rope().winch ? add_rope("hoist", 1) : 0;
      add_winches(world_, world_.connectors[reeled], path(Vec3(0.1, 0, 0)), nullptr);
    }
    if (!(features_ & Features{Feature::pin, Feature::cut}).empty()) add_rope("other", -1);
  }

  Features features_;
  World world_;
  Timeline timeline_;
};

std::string what_happens(const MethodInfo& method, const Maker& made) {
  try {
    Simulation simulation(made.world(), make_method(method.name, {}), made.timeline());
    simulation.advance_to(kUntil);
  } catch (const Diverged& stop) {
    return stop.reason;
  }
  return {};
}

/// Runs the world of two features by every method; adds the initials of those that follow it.
void check(Feature a, Feature b, std::string& able) {
  SCOPED_TRACE(std::string(name(a)) + ", " + std::string(name(b)));
  const Maker made({a, b});
  const Features used = features(made.world(), made.timeline());
  EXPECT_TRUE(used.has(a) && used.has(b));
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    SCOPED_TRACE(method.name);
    const auto refusal = find_refusal(method.abilities, made.world(), &made.timeline());
    const std::string said = what_happens(method, made);
    if (!refusal) {
      EXPECT_EQ(said, "");
      able += static_cast<char>(std::toupper(method.name[0]));
      continue;
    }
    EXPECT_EQ(said, words(made.world(), *refusal));
    for (const auto& use : {std::optional(refusal->one), refusal->other}) {
      if (!use) continue;
      EXPECT_TRUE(used.has(use->feature));
      EXPECT_NE(said.find(std::string(name(use->feature)) + " (" + where(made.world(), *use) + ")"),
                std::string::npos)
          << said;
    }
    if (!refusal->other) {
      EXPECT_FALSE(method.abilities.follows.has(refusal->one.feature));
    } else {
      EXPECT_NE(method.abilities.find_apart(refusal->one.feature, refusal->other->feature),
                nullptr);
    }
  }
}

// With TAUT_TABLE in the environment: shows who follows which pair, by the initials of methods.
TEST(Features, EveryPairIsFollowedOrRefusedByName) {
  std::string table = "| |";
  for (std::size_t b = 0; b < kFeatureCount; ++b) {
    table += " " + std::string(name(feature(b))) + " |";
  }
  table += "\n|---|";
  for (std::size_t b = 0; b < kFeatureCount; ++b) table += "---|";
  for (std::size_t a = 0; a < kFeatureCount; ++a) {
    table += "\n| " + std::string(name(feature(a))) + " |";
    for (std::size_t b = 0; b < a; ++b) {
      std::string able;
      check(feature(a), feature(b), able);
      table += " " + (able.empty() ? "." : able) + " |";
    }
    std::string able;
    check(feature(a), feature(a), able);
    table += " **" + able + "** |";
  }
  if (std::getenv("TAUT_TABLE")) std::cout << table << "\n";
}

using Places = std::vector<Vec3>;

/// The places of all particles and free bodies at the end.
Places places(const Maker& made, std::string_view method, const Settings& settings, double until) {
  Simulation simulation(made.world(), make_method(method, settings), made.timeline());
  simulation.advance_to(until);
  Places places;
  for (const Body& body : simulation.world().bodies) places.push_back(body.position);
  for (const auto& connector : simulation.state().connectors) {
    places.insert(places.end(), connector.begin(), connector.end());
  }
  return places;
}

double apart(const Places& a, const Places& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return a.size() == b.size() ? std::sqrt(sum / static_cast<double>(a.size())) : INFINITY;
}

/// Calls visit(pair's names, world) for all pairs that a method follows.
template <class Visit>
void each_pair(std::string_view method, Visit visit, std::size_t every = 1) {
  for (std::size_t a = 0; a < kFeatureCount; ++a) {
    for (std::size_t b = a % every; b <= a; b += every) {
      const Maker made({feature(a), feature(b)});
      if (find_refusal(find_method(method)->abilities, made.world(), &made.timeline())) continue;
      SCOPED_TRACE(std::string(name(feature(a))) + ", " + std::string(name(feature(b))));
      EXPECT_NO_THROW(visit(made));
    }
  }
}

constexpr double kEnd = 0.25;  // s

// What any two features do together is off by no more than the tolerance, as the truth tells; of a
// tight one by no more in 95%, by three times as much in 99%.
void expect_pairs_to_keep_the_tolerance(std::size_t every) {
  constexpr double kLoose = 1e-3, kTight = 1e-5;
  int all = 0, once = 0, thrice = 0;
  each_pair(
      "direct",
      [&](const Maker& made) {
        const Places truth = places(made, "truth", {}, kEnd);
        EXPECT_LT(apart(places(made, "direct", {{"tolerance", kLoose}}, kEnd), truth), kLoose);
        const double error = apart(places(made, "direct", {{"tolerance", kTight}}, kEnd), truth);
        ++all;
        once += error <= kTight ? 1 : 0;
        thrice += error <= 3 * kTight ? 1 : 0;
      },
      every);
  EXPECT_GT(all, 400 / int(every));
  EXPECT_GE(once, 0.95 * all);
  EXPECT_GE(thrice, 0.99 * all);
}

TEST(Features, EveryFourthPairKeepsTheTolerance) {
  expect_pairs_to_keep_the_tolerance(4);
}
TEST(LongFeatures, PairsKeepTheTolerance) {
  expect_pairs_to_keep_the_tolerance(1);
}

// Of first order in the step, or a millimetre off.
void expect_pairs_to_converge_by_xpbd(std::size_t every) {
  constexpr double kSoon = 0.1;  // s
  each_pair(
      "xpbd",
      [&](const Maker& made) {
        const Places truth = places(made, "truth", {}, kSoon);
        const double coarse = apart(places(made, "xpbd", {{"step", 2e-4}}, kSoon), truth);
        const double fine = apart(places(made, "xpbd", {{"step", 4e-5}}, kSoon), truth);
        EXPECT_TRUE(fine < 1e-3 || fine < coarse / 2.4) << coarse << ' ' << fine;
      },
      every);
}

TEST(Features, EveryFourthPairConvergesByXpbd) {
  expect_pairs_to_converge_by_xpbd(4);
}
TEST(LongFeatures, PairsConvergeByXpbd) {
  expect_pairs_to_converge_by_xpbd(1);
}

TEST(Features, AMethodThatIsAskedAloneNamesWhereTheyAre) {
  const Maker made({Feature::bending, Feature::obstacle});
  EXPECT_EQ(refusal(*find_method("impulse"), made.world()),
            "does not follow bending (connector rope)");
  EXPECT_EQ(methods_that_follow(made.world()), "springs, xpbd, direct, truth");
  EXPECT_EQ(refusal(*find_method("xpbd"), Maker({Feature::winch, Feature::taper}).world()),
            "does not follow winches (connector rope) together with taper (connector rope)");
}

// Rope that flows through a winch may not stretch yet; another rope may.
TEST(Features, PairsOfOneConnectorAreRefusedThereAlone) {
  const Abilities abilities{Features::all(),
                            {{Feature::winch, Feature::stretch, "", Apart::Within::connector}}};
  const Maker both({Feature::winch, Feature::stretch});
  const auto refused = find_refusal(abilities, both.world());
  ASSERT_TRUE(refused && refused->other);
  EXPECT_EQ(refused->one.index, 0u);
  World apart = Maker(Feature::winch).world();
  Connector other = straight_connector("other", 1, 1, 3, Vec3(1, 0, 0), -Vec3::UnitY());
  other.sections.resize(2, Section{.axial_stiffness = 1e3});
  apart.connectors.push_back(other);
  EXPECT_FALSE(find_refusal(abilities, apart));
}

}  // namespace
}  // namespace taut::features_test
