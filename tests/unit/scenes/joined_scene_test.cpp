// Connectors that are joined, and nets: what they are read as, and what is said against them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::joined_scene_test {
namespace {

const std::string kHead = "duration = 1.0\n[method]\nname = \"direct\"\n";
const std::string kTrunk =
    "[connectors.trunk]\nlength = 1.0\nmass = 0.1\nparticles = 11\nfrom = { fixed = [0, 2, 0] }\n"
    "to = { free = true }\n";

std::string branch(const std::string& from, const std::string& more = "") {
  return "[connectors.branch]\nlength = 0.5\nmass = 0.1\nparticles = 6\nfrom = { " + from +
         " }\nto = { free = true }\nstart = { direction = [1, 0, 0] }\n" + more + "\n";
}

std::string ring(const std::string& to, const std::string& start) {
  return "[connectors.ring]\nlength = 1.2\nmass = 0.1\nparticles = 13\nfrom = { free = true }\n"
         "to = { " +
         to + " }\n" + start + "\n";
}

std::string net(const std::string& kind, const std::string& held, const std::string& more = "",
                const std::string& cells = "[8, 4]") {
  return "[nets.n]\nkind = \"" + kind +
         "\"\norigin = [0, 2, 0]\nacross = [1, 0, 0]\ndown = [0, -1, 0]\nsize = [2.0, 1.0]\n"
         "mass = 0.6\ncells = " +
         cells + "\nheld = \"" + held + "\"\n" + more + "\n";
}

class JoinedScene : public SceneTexts {};

/// All joints are closed, and all links have their length.
void expect_whole(const World& world) {
  EXPECT_EQ(joint_flaw(world), "");
  EXPECT_LT(stretch_max(world), 1e-12);
  for (const Joint& joint : world.joints) {
    const Joint::Particle& first = joint.particles[0];
    for (const Joint::Particle& at : joint.particles) {
      EXPECT_EQ(world.connectors[at.connector].position[at.particle],
                world.connectors[first.connector].position[first.particle]);
    }
  }
}

// In whatever order the file names them, a branch begins where its trunk is.
TEST_F(JoinedScene, ABranchBeginsWhereItIsJoined) {
  const std::string joined = branch("connector = \"trunk\", at = 0.4");
  for (const std::string& text : {kHead + kTrunk + joined, kHead + joined + kTrunk}) {
    const World world = read(text).world;
    ASSERT_EQ(world.joints.size(), 1u);
    EXPECT_EQ(world.joints[0].particles.size(), 2u);
    const bool first = world.connectors[0].name == "trunk";
    const Connector &trunk = world.connectors[first ? 0 : 1],
                    &twig = world.connectors[first ? 1 : 0];
    EXPECT_EQ(trunk.position[4], twig.position[0]);
    EXPECT_LT((twig.position[0] - Vec3(0, 1.6, 0)).norm(), 1e-9);
    EXPECT_TRUE(twig.holds.empty());
    expect_whole(world);
  }
}

TEST_F(JoinedScene, EndsThatMeetAtOnePlaceAreOneJoint) {
  std::string other = branch("connector = \"branch\", at = 0");
  other.replace(other.find("branch"), 6, "second");
  const World world = read(kHead + kTrunk + branch("connector = \"trunk\", at = 1") + other).world;
  ASSERT_EQ(world.joints.size(), 1u);
  EXPECT_EQ(world.joints[0].particles.size(), 3u);
  EXPECT_NEAR(joined_mass(world, 0, 10), 0.1 / 11 + 2 * 0.1 / 6, 1e-15);
}

TEST_F(JoinedScene, ALoopIsAPolygon) {
  const World world =
      read(kHead + ring("connector = \"ring\", at = 0",
                        "start = { circle = { centre = [1, 2, 3], axis = [0, 0, 2] }, spin = [0, "
                        "0, 5] }"))
          .world;
  const Connector& loop = world.connectors[0];
  const double radius = 0.1 / (2 * std::sin(std::numbers::pi / 12));
  for (std::size_t i = 0; i < 13; ++i) {
    EXPECT_NEAR((loop.position[i] - Vec3(1, 2, 3)).norm(), radius, 1e-12);
    EXPECT_NEAR(loop.position[i].z(), 3, 1e-12);
    EXPECT_NEAR(loop.velocity[i].norm(), 5 * radius, 1e-12);
  }
  expect_whole(world);
}

// The particle where it closes is no heavier than the others: what spins stays round as it falls.
TEST_F(JoinedScene, ASpinningLoopKeepsItsCircle) {
  const World start =
      read(kHead + ring("connector = \"ring\", at = 0",
                        "start = { circle = { centre = [0, 0, 0], axis = [0, 0, 1] }, spin = [0, "
                        "0, 5] }"))
          .world;
  const Connector& loop = start.connectors[0];
  for (std::size_t i = 0; i < 13; ++i) {
    EXPECT_NEAR(joined_mass(start, 0, i), loop.mass / 12, 1e-15);
  }
  Simulation simulation(start, make_method("direct", {{"tolerance", 1e-7}}));
  simulation.advance_to(1);
  const Vec3 centre = start.gravity / 2;
  const double radius = 0.1 / (2 * std::sin(std::numbers::pi / 12));
  for (const Vec3& at : simulation.world().connectors[0].position) {
    EXPECT_NEAR((at - centre).norm(), radius, 1e-6);
  }
}

TEST_F(JoinedScene, FaultsOfJoinedEndsAreNamed) {
  const auto fault = [&](const std::string& from, const std::string& words) {
    expect(kHead + kTrunk + branch(from), words);
  };
  fault("connector = \"trunc\", at = 0.4", "expected the name of a connector, did you mean");
  fault("connector = \"trunk\"", "needs at");
  fault("free = true, at = 0.4", "needs connector");
  fault("connector = \"trunk\", at = 1.1", "at most the length of trunk, 1 m");
  fault("connector = \"trunk\", at = 0.46", "the place of a particle of trunk, such as 0.5 m");
  fault("connector = \"trunk\", at = -1", "at least 0");
  fault("connector = \"trunk\", at = 0.4, clamp = [1, 0, 0]", "bends freely has no direction");
  fault("connector = \"trunk\", at = 0.4, fixed = [0, 0, 0]", "only one of");
  fault("connector = \"branch\", at = 0.2", "joins the connector to itself with 2 links between");
  const std::string joined = "connector = \"trunk\", at = 0.4";
  expect(kHead + kTrunk + branch(joined, "repeat = [{ count = 2, by = [0, 0, 1] }]"),
         "needs ends that are free, fixed");
  expect(kHead + kTrunk + branch(joined, "model = \"span\""), "massless span");
  std::string elsewhere = branch(joined);
  elsewhere.replace(elsewhere.find("direction = [1, 0, 0]"), 21, "points = [[0, 0, 0], [1, 0, 0]]");
  expect(kHead + kTrunk + elsewhere, "m away from its place on trunk at the start");
  expect(kHead + branch("connector = \"second\", at = 0") +
             "[connectors.second]\nlength = 0.5\nmass = 0.1\nparticles = 6\n"
             "from = { connector = \"branch\", at = 0 }\nto = { free = true }\n",
         "neither end has a place");
}

TEST_F(JoinedScene, FaultsOfLoopsAreNamed) {
  expect(kHead + ring("connector = \"ring\", at = 0", ""), "is a closed loop");
  const std::string circle = "start = { circle = { centre = [0, 0, 0], axis = [0, 0, 1] } }";
  expect(kHead + ring("free = true", circle),
         "needs an end that is joined to the connector's first");
  expect(kHead + ring("connector = \"ring\", at = 1.1", circle), "with 1 links between");
}

TEST_F(JoinedScene, OtherMethodsAreRefused) {
  for (const MethodInfo& method : all_methods()) {
    std::string text = kHead + kTrunk + branch("connector = \"trunk\", at = 0.4");
    text.replace(text.find("direct"), 6, method.name);
    if (method.abilities.follows.has(Feature::joint)) {
      EXPECT_EQ(said(text), "nothing") << method.name;
    } else if (method.missing.empty()) {
      expect(text, "does not follow joints, expected one of: springs, xpbd, direct");
    }
  }
}

TEST_F(JoinedScene, NetsLaddersAndWebs) {
  struct Case {
    std::string text;
    std::size_t cords, joints, particles, holds;
  };
  const Case cases[] = {
      // 9 ropes of 5 knots and 5 of 9, which cross in 45.
      {net("net", "upper edge"), 14, 45, 90, 9},
      {net("net", "upper corners", "slack = 0.1"), 14, 45, 90, 2},
      {net("net", "corners", "slack = 0.1\nlinks = 3\npleats = 3"), 14, 45, 9 * 13 + 5 * 25, 4},
      {net("net", "edges", "axial_stiffness = 100"), 14, 45, 90, 24},
      {net("net", "nothing"), 14, 45, 90, 0},
      // Two ropes of 12 links, with 5 rungs.
      {net("ladder", "upper corners", "links = 3", "[1, 4]"), 7, 10, 2 * 13 + 5 * 2, 2},
      // 8 spokes of 4 links; 3 rings, and a fourth where nothing holds the rim.
      {net("web", "edges", "slack = 0.05"), 11, 1 + 3 * 8, 8 * 5 + 3 * 9, 8},
      {net("web", "nothing"), 12, 1 + 4 * 8, 8 * 5 + 4 * 9, 0},
  };
  for (const Case& each : cases) {
    SCOPED_TRACE(each.text);
    const scenes::Scene scene = read(kHead + each.text + "[stage]\n", true);
    const World& world = scene.world;
    EXPECT_EQ(world.connectors.size(), each.cords);
    EXPECT_EQ(scene.stage->connector_looks.size(), each.cords);
    EXPECT_EQ(world.joints.size(), each.joints);
    std::size_t particles = 0, holds = 0;
    double mass = 0;
    for (const Connector& cord : world.connectors) {
      particles += cord.particles();
      holds += cord.holds.size();
      for (const double part : cord.particle_mass) mass += part;
    }
    EXPECT_EQ(particles, each.particles);
    EXPECT_EQ(holds, each.holds);
    EXPECT_NEAR(mass, 0.6, 1e-12);
    expect_whole(world);
    EXPECT_EQ(world.connectors[0].name, "n#1");
  }
}

std::string part(const std::string& name, double length, double mass, int particles,
                 const std::string& from, const std::string& to) {
  return fmt::format(
      "[connectors.{}]\nlength = {}\nmass = {}\nparticles = {}\nfrom = {{ {} }}\nto = {{ {} }}\n",
      name, length, mass, particles, from, to);
}

// Joined end to end they hang as one between their outer ends, in whatever direction each goes.
TEST_F(JoinedScene, WhatIsJoinedEndToEndStartsAtRest) {
  const std::string here = "fixed = [0, 0, 0]", there = "fixed = [3, 1, 0]", none = "free = true";
  const std::string chain = part("chain", 2, 3, 11, here, none);
  for (const std::string& line :
       {chain + part("rope", 2, 0.1, 9, "connector = \"chain\", at = 2", there),
        chain + part("rope", 2, 0.1, 9, there, "connector = \"chain\", at = 2"),
        part("rope", 2, 0.1, 9, "connector = \"chain\", at = 0", there) +
            part("chain", 2, 3, 11, none, here),
        chain +
            part("rope", 2, 0.1, 9, "connector = \"chain\", at = 2",
                 "connector = \"end\", at = 0") +
            part("end", 1, 2, 6, none, there)}) {
    SCOPED_TRACE(line);
    const scenes::Scene scene = read(kHead + line);
    expect_whole(scene.world);
    Simulation simulation = scenes::start(scene, scene.method);
    simulation.advance_to(0.5);
    for (std::size_t c = 0; c < scene.world.connectors.size(); ++c) {
      const auto& before = scene.world.connectors[c].position;
      const auto& after = simulation.world().connectors[c].position;
      for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_LT((after[i] - before[i]).norm(), 1e-9) << c << ", " << i;
    }
  }
  expect(
      kHead + chain + part("rope", 2, 0.1, 9, "connector = \"chain\", at = 2", "fixed = [3, 3, 0]"),
      "the line of 2 connectors joined end to end are 4.24264 m apart, expected at most its "
      "length, 4 m");
}

// Numbers beyond what the arithmetic bears are refused where they stand.
TEST_F(JoinedScene, NumbersWithoutDigitsAreRefused) {
  expect(kHead + part("rope", 1, 0.1, 11, "fixed = [1e15, 0, 0]", "free = true") +
             "start = { direction = [1, 0, 0] }\n",
         "connectors.rope: a link of 0.1 m at [1e+15, 0, 0] comes out 0.125 m long");
  expect(kHead + part("rope", 1e-200, 0.1, 3, "fixed = [0, 0, 0]", "free = true"),
         "comes out 0 m long");
  expect("gravity = [1e308, -1e308, 0]\n" + kHead, "gravity[0]: found 1e+308");
}

TEST_F(JoinedScene, CordsOfNetsHaveTheKeysOfConnectors) {
  const std::string keys =
      "bending_stiffness = 0.2\nbending_damping = 0.01\ndrag = { across = 1.2, along = 0.1 }\n"
      "radius = 0.02\ncontact = \"links\"\ncords = \"pull\"\nrestitution = 0.5\n";
  const World world = read("air = {}\n" + kHead + net("net", "nothing", keys)).world;
  for (const Connector& cord : world.connectors) {
    ASSERT_EQ(cord.sections.size(), cord.links());
    EXPECT_EQ(cord.sections[0].bending_stiffness, 0.2);
    EXPECT_EQ(cord.sections[0].bending_damping, 0.01);
    EXPECT_EQ(cord.drag.across, 1.2);
    EXPECT_EQ(cord.radius, 0.02);
    EXPECT_EQ(cord.restitution, 0.5);
    EXPECT_TRUE(cord.links_touch && cord.pulls);
  }
  // Of a material, every metre weighs the same, also in rings whose links differ.
  std::string web = net("web", "nothing",
                        "material = { youngs_modulus = 1e6, diameter = 0.01, "
                        "density = 1000 }");
  web.replace(web.find("mass = 0.6\n"), 11, "");
  const World made = read(kHead + web).world;
  const double density = 1000 * std::numbers::pi * 0.01 * 0.01 / 4;
  for (const Connector& cord : made.connectors) {
    EXPECT_TRUE(cord.stretches() && cord.sections[0].bending_stiffness > 0);
    double mass = 0, first = density * cord.rest[0] / 2;
    for (const double part : cord.particle_mass) mass += part;
    EXPECT_NEAR(mass, density * cord.length, 1e-12);
    EXPECT_NEAR(cord.particle_mass[0], first, 1e-12);
  }
}

// The share by which the way is shorter than the cord, and both ends on the line between.
TEST_F(JoinedScene, SlackOfANet) {
  const World world = read(kHead + net("net", "upper corners", "slack = 0.2\npleats = 2")).world;
  const Connector& top = world.connectors[9];  // behind the nine ropes
  EXPECT_LT((top.position.front() - Vec3(0, 2, 0)).norm(), 1e-12);
  EXPECT_LT((top.position.back() - Vec3(0.8 * 2, 2, 0)).norm(), 1e-12);
  EXPECT_NEAR(top.length, 2, 1e-12);
}

TEST_F(JoinedScene, FaultsOfNetsAreNamed) {
  expect(kHead + net("net", "corners"), "leaves no room to move; expected slack above 0");
  expect(kHead + net("web", "edges"), "leaves no room to move");
  expect(kHead + net("web", "corners", "slack = 0.1"), "nothing or edges, of a web");
  expect(kHead + net("web", "edges", "slack = 0.1", "[2, 4]"), "at least 3 spokes");
  expect(kHead + net("net", "corners", "slack = 0.1\npleats = 2"), "at least 4 links for each");
  expect(kHead + net("net", "nothing", "axial_damping = 1"), "needs axial_stiffness");
  expect(kHead + net("net", "nothing", "links = 1000", "[1000, 1000]"), "particles in all");
  expect(kHead + net("net", "nobody"), "expected one of: nothing, upper corners");
  expect(kHead + net("net", "nothing", "", "[0, 4]"), "found 0");
  std::string flat = net("net", "nothing");
  flat.replace(flat.find("[0, -1, 0]"), 10, "[-2, 0, 0]");
  expect(kHead + flat, "another direction than across");
  std::string twice = kTrunk + net("net", "nothing");
  twice.replace(twice.find("nets.n"), 6, "nets.trunk");
  expect(kHead + twice, "is the name of a connector already");
}

}  // namespace
}  // namespace taut::joined_scene_test
