// Scenes of scenes/materials against what is known of them: a jump, rods in a wall, a streamer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "heavy_elastica.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"
#include "tests/support/folder.h"

namespace taut::material_scenes_test {
namespace {

using material_worlds::HeavyElastica;

constexpr double kGravity = 9.81;

scenes::Scene shipped(const std::string& name, const std::vector<scenes::SceneChange>& changes) {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/materials/" + name + ".toml", false, changes);
}

/// The lowest point (m) of the first fall of the jumper.
double lowest(const std::vector<scenes::SceneChange>& changes) {
  const scenes::Scene scene = shipped("bungee", changes);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-3}}));
  double least = 100;
  for (double time = 0; time < 4; time += 0.01) {
    simulation.advance_to(time);
    least = std::min(least, simulation.world().connectors[0].position.back().y());
  }
  return least;
}

// From so far above what holds the rubber, h below it: m g (above + h) = EA (h/L - 1)^2 L / 2. A
// body that starts aside, by 1/20 of h, keeps (1/20)^2 of the energy at most in going across. The
// rope's weight and inertia count by its share of the mass, as do its damping and the air.
TEST(Bungee, FallsAsFarAsItsEnergyTakes) {
  const Vec3 start = shipped("bungee", {}).world.connectors[0].position.back();
  const double mass = 70, length = 10, stiffness = 4000, above = start.y() - 30;
  double low = length, high = 10 * length;
  while (high - low > 1e-9) {
    const double h = (low + high) / 2, stretch = h - length;
    const bool deeper = mass * kGravity * (above + h) > stiffness / length * stretch * stretch / 2;
    (deeper ? low : high) = h;
  }
  const double aside = std::pow(start.x() / low, 2);
  const double light = lowest({{"connectors.rubber.mass", "0.5"},
                               {"connectors.rubber.axial_damping", "0"},
                               {"air.density", "0"}});
  EXPECT_NEAR((30 - light) / low, 1, aside + 0.5 / 70);
  EXPECT_NEAR((30 - lowest({})) / low, 1, aside + 5.0 / 70);
}

/// The curvature at the wall of a rod that is free at its end, by Newton's method from a guess.
double curvature_at_wall(const HeavyElastica& rod, double curvature) {
  const auto end_curvature = [&](double at_wall) {
    double last = 0;
    rod.follow({at_wall, 0, -rod.weight * rod.length},
               [&](int, const HeavyElastica::State& at) { last = at[1]; });
    return last;
  };
  for (int i = 0; i < 20; ++i) {
    const double miss = end_curvature(curvature), step = 1e-6 * (1 + std::abs(curvature));
    curvature -= miss * step / (end_curvature(curvature + step) - miss);
  }
  EXPECT_LT(std::abs(end_curvature(curvature)), 1e-8);
  return curvature;
}

/// How far the end of each rod of so many links is from its elastica's, at rest, m.
std::vector<double> ends_off(std::size_t links) {
  std::vector<scenes::SceneChange> changes{{"duration", "300"}};
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    const std::string rod = std::string("connectors.") + name;
    changes.emplace_back(rod + ".particles", std::to_string(links + 1));
    changes.emplace_back(rod + ".taper", "[1.0, 1.0]");  // half of a link's mass at either end
  }
  const scenes::Scene scene = shipped("cantilever", changes);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-4}}));
  simulation.advance_to(300);
  std::vector<double> off;
  for (const Connector& rod : simulation.world().connectors) {
    const double stiffness = rod.sections[0].bending_stiffness;
    const double weight = kGravity * rod.mass / rod.length;
    const HeavyElastica known{stiffness, weight, rod.length, 0};
    const Vec3 first = rod.position[1] - rod.position[0];
    const double guess = std::atan2(first.y(), first.x()) / (rod.rest[0] / 2);
    Vec3 end = Vec3::Zero();
    known.follow({curvature_at_wall(known, guess), 0, -weight * rod.length},
                 [&](int, const HeavyElastica::State& at) { end = Vec3(at[2], at[3], 0); });
    off.push_back((rod.position.back() - rod.position[0] - end).norm());
    const double little = weight * std::pow(rod.length, 4) / (8 * stiffness);
    if (little < 0.02) {
      EXPECT_NEAR(-end.y() / little, 1, 1e-3) << rod.name;
    }
  }
  return off;
}

// Each comes to rest as the elastica under its own weight, off by the square of the links' length;
// the stiffest sags by w L^4 / (8 EI).
TEST(Cantilever, RodsRestAsHeavyElasticas) {
  const std::vector<double> coarse = ends_off(80), fine = ends_off(160);
  ASSERT_EQ(coarse.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT(coarse[i], 2e-4) << i;
    EXPECT_NEAR(coarse[i] / fine[i], 4, 0.4) << i;
  }
}

// In a steady wind it lies straight, at the angle to the wind that the scene's text gives.
TEST(FlagRope, LiesStraightInASteadyWind) {
  std::ifstream file(TAUT_SOURCE_DIR "/scenes/materials/flag_rope.toml");
  std::stringstream read;
  read << file.rdbuf();
  std::string text = read.str();
  const auto replace = [&](const std::string& what, const std::string& by) {
    ASSERT_NE(text.find(what), std::string::npos) << what;
    text.replace(text.find(what), what.size(), by);
  };
  replace("file = \"gusts.csv\"", "wind = [8.0, 0.0, 0.0]");
  replace("particles = 81", "particles = 81\ntaper = [1.0, 1.0]");  // halves of links at its ends
  const Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("flag.toml", text), false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-5}}));
  simulation.advance_to(60);
  const Connector& rope = simulation.world().connectors[0];
  const double drag = 1.225 * 1.2 * 0.018 * 8 * 8 / 2;
  const double weight = kGravity * rope.mass / rope.length;
  const double cosine =  // of drag sin^2 = weight cos
      (std::sqrt(weight * weight + 4 * drag * drag) - weight) / (2 * drag);
  const Vec3 way(cosine, -std::sqrt(1 - cosine * cosine), 0);
  for (std::size_t i = 0; i < rope.particles(); ++i) {
    const Vec3 known = rope.position[0] + static_cast<double>(i) * rope.rest[0] * way;
    EXPECT_LT((rope.position[i] - known).norm(), 1e-5) << i;
  }
}

}  // namespace
}  // namespace taut::material_scenes_test
