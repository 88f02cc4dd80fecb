// Materials of scenes: what they are read as, and what is said against them.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/run/simulation.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::material_scene_test {
namespace {

/// A scene of one rope with these keys, and what stands beside it.
std::string rope_with(const std::string& keys, const std::string& from = "fixed = [0, 1, 0]",
                      const std::string& beside = "", const std::string& method = "direct") {
  return beside + "\nduration = 1.0\n[method]\nname = \"" + method +
         "\"\n[connectors.rope]\nlength = 2.0\nparticles = 5\nfrom = { " + from +
         " }\nto = { free = true }\nstart = { direction = [1, 0, 0] }\n" + keys + "\n";
}

class MaterialScene : public SceneTexts {
 protected:
  Connector rope(const std::string& text) const { return read(text).world.connectors[0]; }
};

TEST_F(MaterialScene, StiffnessesAreRead) {
  const Connector made =
      rope(rope_with("mass = 1\naxial_stiffness = 50\naxial_damping = 2\nbending_stiffness = 3\n"
                     "bending_damping = 0.5\nradius = 0.02\ndrag = { across = 1.2, along = 0.1 }",
                     "fixed = [0, 1, 0], clamp = [2, 0, 0]", "air = { wind = [1, 2, 3] }"));
  ASSERT_EQ(made.sections.size(), 4u);
  for (const Section& section : made.sections) {
    EXPECT_EQ(section.axial_stiffness, 50);
    EXPECT_EQ(section.axial_damping, 2);
    EXPECT_EQ(section.bending_stiffness, 3);
    EXPECT_EQ(section.bending_damping, 0.5);
    EXPECT_EQ(section.diameter, 0.04);
  }
  EXPECT_EQ(made.drag.across, 1.2);
  EXPECT_EQ(made.drag.along, 0.1);
  EXPECT_EQ(made.holds[0].clamp, Vec3(1, 0, 0));
  for (const double mass : made.particle_mass) EXPECT_DOUBLE_EQ(mass, 0.2);
  EXPECT_TRUE(made.stretches());
}

TEST_F(MaterialScene, WithoutAnyNothingIsMade) {
  const World world = read(rope_with("mass = 1", "fixed = [0, 1, 0]", "air = {}")).world;
  EXPECT_TRUE(world.connectors[0].sections.empty());
  EXPECT_FALSE(has_materials(world));
  EXPECT_EQ(world.air.density, 1.225);
}

// Between ends that are farther apart than its length a string starts under tension; plucked in its
// middle, it is straight after a quarter of its period, as all odd harmonics are.
TEST_F(MaterialScene, WhatStretchesStartsUnderTension) {
  const auto text = [](const std::string& start) {
    return "duration = 1.0\ngravity = [0, 0, 0]\n[method]\nname = \"direct\"\ntolerance = 1e-6\n"
           "[connectors.string]\nlength = 1.0\nmass = 0.02\nparticles = 41\n"
           "axial_stiffness = 2000\nfrom = { fixed = [0, 0, 0] }\n"
           "to = { fixed = [1.02, 0, 0] }\n" +
           start + "\n";
  };
  const Connector straight = rope(text(""));
  for (std::size_t i = 0; i < 41; ++i) {
    const Vec3 even(1.02 * static_cast<double>(i) / 40, 0, 0);
    EXPECT_LT((straight.position[i] - even).norm(), 1e-12);
  }
  constexpr double kPlucked = 1e-3;
  const scenes::Scene scene =
      read(text("start = { points = [[0, 0, 0], [0.51, 0.001, 0], [1.02, 0, 0]] }"));
  EXPECT_NEAR(scene.world.connectors[0].position[20].y(), kPlucked, 1e-12);
  Simulation simulation = scenes::start(scene);
  const double speed = std::sqrt(2000 * 0.02 / (0.02 / 1.02));  // m/s, of waves
  const auto middle = [&] { return simulation.world().connectors[0].position[20].y(); };
  simulation.advance_to(1.02 / speed / 2);
  EXPECT_NEAR(middle(), 0, 0.05 * kPlucked);
  simulation.advance_to(1.02 / speed);
  EXPECT_NEAR(middle(), -kPlucked, 0.08 * kPlucked);
  // Held at one end alone, it is laid as long as it is.
  const std::string free = text("start = { points = [[0, 0, 0], [3, 0, 0]] }");
  EXPECT_NEAR(rope(std::string(free).replace(free.find("fixed = [1.02, 0, 0]"), 20, "free = true"))
                  .position[40]
                  .x(),
              1, 1e-12);
}

TEST_F(MaterialScene, GustsAreRead) {
  folder_.write("gusts.csv", "t,x,y,z\n0,1,0,0\n2,5,0,1\n");
  const std::string gusty = "air = { file = \"gusts.csv\" }", hold = "fixed = [0, 1, 0]";
  const World world = read(rope_with("mass = 1\ndrag = { across = 1 }", hold, gusty)).world;
  EXPECT_EQ(world.air.wind_at(0), Vec3(1, 0, 0));
  EXPECT_EQ(world.air.wind_at(3), Vec3(5, 0, 1));
  folder_.write("gusts.csv", "t,x,y\n0,1,0\n");
  EXPECT_NE(said(rope_with("mass = 1", hold, gusty)).find("gusts.csv:1: expected the columns"),
            std::string::npos);
}

// EA = E pi d^2 / 4, EI = E pi d^4 / 64, and each link's mass at its ends.
TEST_F(MaterialScene, AMaterialGivesStiffnessAndMass) {
  const Connector made =
      rope(rope_with("material = { youngs_modulus = 1e6, diameter = 0.1, density = 1000 }"));
  const double area = std::numbers::pi * 0.01 / 4;
  EXPECT_NEAR(made.sections[0].axial_stiffness, 1e6 * area, 1e-9);
  EXPECT_NEAR(made.sections[0].bending_stiffness, 1e6 * std::numbers::pi * 1e-4 / 64, 1e-12);
  EXPECT_NEAR(made.mass, 2000 * area, 1e-12);
  EXPECT_NEAR(made.particle_mass[0], made.mass / 8, 1e-12);
  EXPECT_NEAR(made.particle_mass[2], made.mass / 4, 1e-12);
}

// Diameters 1, 0.5, 0.5 over four links: 0.875 and 0.625 in the first two, 0.5 in the others.
TEST_F(MaterialScene, ATaperChangesWhatDependsOnTheDiameter) {
  const Connector made = rope(rope_with(
      "mass = 1\naxial_stiffness = 100\nbending_stiffness = 10\ntaper = [1.0, 0.5, 0.5]"));
  const double shares[] = {0.75 + 0.125, 0.5 + 0.125, 0.5, 0.5};
  double weight = 0, sum = 0;
  for (const double share : shares) weight += share * share;
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(made.sections[k].axial_stiffness, 100 * std::pow(shares[k], 2), 1e-12);
    EXPECT_NEAR(made.sections[k].bending_stiffness, 10 * std::pow(shares[k], 4), 1e-12);
  }
  for (const double mass : made.particle_mass) sum += mass;
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_NEAR(made.particle_mass[0], shares[0] * shares[0] / weight / 2, 1e-12);
}

TEST_F(MaterialScene, FaultsAreNamed) {
  expect(rope_with("mass = 1\naxial_stiffness = -5"), "found -5, expected a number above 0");
  expect(rope_with("mass = 1\nbending_stiffness = -1"), "found -1, expected a number of at least");
  expect(rope_with("mass = 1\nmaterial = { youngs_modulus = 1, diameter = 1, density = 1 }"),
         "only one of: mass, material");
  expect(rope_with("bending_stiffness = 1"), "expected one of: mass, material");
  expect(rope_with("bending_stiffness = 1\nmaterial = { youngs_modulus = 1, diameter = 1, "
                   "density = 1 }"),
         "only one of: bending_stiffness, material");
  expect(rope_with("mass = 1\naxial_damping = 1"), "needs axial_stiffness or material");
  expect(rope_with("mass = 1\ndrag = { across = 1 }"), "needs a table air");
  expect(rope_with("mass = 1\nbending_stiffness = 1\ntaper = [1.0]"), "at least 2 numbers");
  expect(rope_with("mass = 1\nbending_stiffness = 1\nmodel = \"span\""), "needs model = \"links\"");
}

TEST_F(MaterialScene, ClampsNeedADirectionToHold) {
  const std::string clamped = "fixed = [0, 1, 0], clamp = [1, 0, 0]";
  expect(rope_with("mass = 1", clamped), "bends freely has no direction at its end");
  expect(rope_with("mass = 1\nbending_stiffness = 1", "fixed = [0, 1, 0], clamp = [0, 0, 0]"),
         "vector of length 0");
  EXPECT_EQ(said(rope_with("mass = 1\nbending_stiffness = 1", clamped)), "nothing");
  const std::string loose =
      "duration = 1.0\n[connectors.rope]\nlength = 2.0\nparticles = 5\n"
      "mass = 1\nbending_stiffness = 1\nfrom = { fixed = [0, 0, 0] }\n"
      "to = { free = true, clamp = [1, 0, 0] }\n"
      "start = { direction = [1, 0, 0] }\n[method]\nname = \"direct\"\n";
  expect(loose, "needs an end that is held");
}

TEST_F(MaterialScene, OtherMethodsAreRefused) {
  const std::string keys = "mass = 1\nbending_stiffness = 1";
  for (const MethodInfo& method : all_methods()) {
    const std::string text = rope_with(keys, "fixed = [0, 1, 0]", "", std::string(method.name));
    if (method.abilities.follows.has(Feature::bending)) {
      EXPECT_EQ(said(text), "nothing") << method.name;
    } else if (method.missing.empty()) {
      expect(text, "expected one of: springs, xpbd, direct, truth");
    }
  }
  EXPECT_EQ(said(rope_with(keys, "fixed = [0, 1, 0]", "", "truth") +
                 "[obstacles.floor]\nshape = { plane = {} }\nposition = [0, -2, 0]\n"),
            "nothing");
  expect(rope_with(keys, "fixed = [0, 1, 0]", "", "springs") +
             "[connectors.pull]\nlength = 1\nmass = 1\nparticles = 3\nlinks = \"pull\"\n"
             "bending_stiffness = 1\nfrom = { fixed = [1, 1, 0] }\nto = { free = true }\n",
         "connectors.pull.bending_stiffness: the method springs does not follow bending together "
         "with strings (connectors.pull.links, line");
}

/// A rope between two clamps along x, with `turn` beside the second.
std::string twisted(const std::string& keys, const std::string& turn,
                    const std::string& clamp = ", clamp = [1, 0, 0]") {
  return "duration = 1.0\n[method]\nname = \"direct\"\n[connectors.rope]\nlength = 2.0\n"
         "particles = 5\nfrom = { fixed = [0, 0, 0], clamp = [1, 0, 0] }\nto = { fixed = [2, 0, "
         "0]" +
         clamp + turn + " }\nstart = { direction = [1, 0, 0] }\n" + keys + "\n";
}

TEST_F(MaterialScene, TwistIsRead) {
  const std::string turn = ", turn = [{ t = 0, angle = 0 }, { t = 2, angle = 8 }]";
  const Connector made = rope(
      twisted("mass = 1\nbending_stiffness = 3\ntwisting_stiffness = 2\ntwisting_damping = 0.1\n"
              "rest_twist = 0.5",
              turn));
  for (const Section& section : made.sections) {
    EXPECT_EQ(section.twisting_stiffness, 2);
    EXPECT_EQ(section.twisting_damping, 0.1);
    EXPECT_EQ(section.rest_twist, 0.5);
  }
  EXPECT_EQ(made.holds[1].turn->at(1).position.x(), 4);
  EXPECT_EQ(made.holds[0].turn, nullptr);
  const std::string material = "material = { youngs_modulus = 1e6, diameter = 0.1, density = 1000";
  const Section metal = rope(twisted(material + " }", "")).sections[0];
  EXPECT_DOUBLE_EQ(metal.twisting_stiffness, metal.bending_stiffness / 1.3);
  const Section rubber = rope(twisted(material + ", poissons_ratio = 0.5 }", "")).sections[0];
  EXPECT_DOUBLE_EQ(rubber.twisting_stiffness, metal.bending_stiffness / 1.5);
}

TEST_F(MaterialScene, FaultsOfTwistAreNamed) {
  const std::string twists = "mass = 1\nbending_stiffness = 3\ntwisting_stiffness = 2\n";
  const std::string turn = ", turn = [{ t = 0, angle = 1 }]";
  EXPECT_EQ(said(twisted(twists, turn)), "nothing");
  expect(twisted(twists, turn, ""), "needs a clamp at both ends");
  expect(twisted("mass = 1\nbending_stiffness = 3", turn), "needs twisting_stiffness or material");
  expect(twisted("mass = 1\ntwisting_stiffness = 2", "", ""),
         "needs bending_stiffness or material");
  expect(twisted("mass = 1\nbending_stiffness = 3\nrest_twist = 2", ""),
         "needs twisting_stiffness or material");
  expect(twisted(twists + "rest_twist = 2\nrest_curvature = [0, 0, 1]", ""), "is not twisted");
  expect(twisted(twists + "rest_curvature = [0, 0, 1]", turn), "is not twisted");
  expect(twisted("mass = 1\nbending_stiffness = 3\ntwisting_stiffness = -2", ""),
         "found -2, expected a number above 0");
  expect(twisted(twists, ", turn = [{ t = 1, angle = 1 }, { t = 1, angle = 2 }]"),
         "a time after 1 s");
  expect(twisted(twists, ", turn = []"), "turn");
}

TEST_F(MaterialScene, RestCurvatureNeedsAPlane) {
  const std::string bends = "mass = 1\nbending_stiffness = 3\nrest_curvature = ";
  const Connector made = rope(rope_with(bends + "[0, 0, 2]"));
  for (const Section& section : made.sections) EXPECT_EQ(section.rest_curvature, Vec3(0, 0, 2));
  expect(rope_with("mass = 1\nrest_curvature = [0, 0, 2]"), "needs bending_stiffness or material");
  for (const char* axis : {"[1, 0, 0]", "[0, 1, 0]", "[0, 0.1, 2]"}) {
    expect(rope_with(bends + axis), "needs a motion in the plane across it");
  }
  expect(rope_with(bends + "[0, 0, 2]", "path = \"hand\"",
                   "paths = { hand = { keys = [{ t = 0, position = [0, 1, 0] }] } }"),
         "ends that are free or fixed");
}

}  // namespace
}  // namespace taut::material_scene_test
