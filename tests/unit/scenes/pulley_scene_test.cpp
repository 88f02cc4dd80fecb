// Pulleys in scene files: what they are read as, and what is said against them.
#include <gtest/gtest.h>

#include "sim/links/tension.h"
#include "sim/run/simulation.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::pulley_scene_test {
namespace {

const std::string kEyes =
    "[pulleys]\nleft = { fixed = [0, 2, 0] }\nright = { fixed = [1, 2, 0], inertia = 0.2 }\n";

struct Rope {
  std::string from = "point_mass = 1.0", to = "point_mass = 2.0";
  std::string over = "[\"left\", \"right\"]";
  std::string start = "before = 0.8";
  std::string length = "2.7", particles = "4", more = {}, eyes = kEyes, method = "direct";
};
std::string scene(const Rope& rope) {
  return "duration = 1.0\n[method]\nname = \"" + rope.method + "\"\n" + rope.eyes +
         "[connectors.rope]\nlength = " + rope.length +
         "\nmass = 0.27\nparticles = " + rope.particles + "\nover = " + rope.over + "\nstart = { " +
         rope.start + " }\nfrom = { " + rope.from + " }\nto = { " + rope.to + " }\n" + rope.more +
         "\n";
}

class PulleyScene : public SceneTexts {
 protected:
  void expect(const Rope& rope, const std::string& words) const {
    SceneTexts::expect(scene(rope), words);
  }
};

TEST_F(PulleyScene, RopeHasASpanBetweenAnyTwo) {
  const World world = read(scene({.more = "[connectors.other]\nlength = 1.0\nmass = 0.1\n"
                                          "particles = 3\nfrom = { fixed = [5, 2, 0] }\n"
                                          "to = { free = true }"}))
                          .world;
  ASSERT_EQ(world.connectors.size(), 4u);
  EXPECT_EQ(world.connectors[2].name, "rope#2");
  EXPECT_DOUBLE_EQ(world.connectors[0].length, 0.8);
  EXPECT_DOUBLE_EQ(world.connectors[2].length, 1.0);
  EXPECT_NEAR(world.connectors[3].length, 0.9, 1e-15);
  EXPECT_NEAR(world.connectors[3].mass, 0.09, 1e-15);
  EXPECT_LT((world.connectors[0].position[0] - Vec3(0, 1.2, 0)).norm(), 1e-15);
  EXPECT_NEAR(world.connectors[3].position[3].y(), 1.1, 1e-15);
  ASSERT_EQ(world.pulleys.size(), 2u);
  EXPECT_EQ(world.pulleys[1].from, 2u);
  EXPECT_EQ(world.pulleys[1].to, 3u);
  EXPECT_EQ(world.pulleys[1].inertia, 0.2);
  // Halves of links: 0.1 kg/m of 0.8/3 m, and the point mass.
  EXPECT_NEAR(world.connectors[0].particle_mass[0], 1 + 0.1 * 0.8 / 6, 1e-15);
  EXPECT_NEAR(world.connectors[0].particle_mass[1], 0.1 * 0.8 / 3, 1e-15);
}

TEST_F(PulleyScene, PulleysHaveFriction) {
  const World world =
      read(scene({.eyes = "[pulleys]\nleft = { fixed = [0, 2, 0], friction = 0.3 }\n"
                          "right = { fixed = [1, 2, 0], bearing = 0.02 }\n"}))
          .world;
  EXPECT_EQ(world.pulleys[0].friction, 0.3);
  EXPECT_EQ(world.pulleys[1].bearing, 0.02);
}

TEST_F(PulleyScene, RopeBetweenHeldEndsStartsTaut) {
  const World world = read(scene({.from = "fixed = [0, 1, 0]",
                                  .to = "fixed = [1, 1.5, 0]",
                                  .start = "direction = [0, -1, 0]",
                                  .length = "2.5001"}))
                          .world;
  EXPECT_DOUBLE_EQ(world.connectors[0].length, 1.0);
  EXPECT_DOUBLE_EQ(world.connectors[2].length, 0.5);
}

TEST_F(PulleyScene, LinkAtAFreeBodyKeepsItsLength) {
  const std::string load =
      "[bodies.load]\nmass = 1.0\nshape = { sphere = { diameter = 0.1 } }\nhangs = [0, -1, 0]\n";
  const Rope rope{.to = "body = \"load\", point = [0, 0.05, 0]", .more = load};
  Simulation simulation(read(scene(rope)).world, make_method("direct", {}));
  simulation.advance_to(0.3);
  const Connector& span = simulation.world().connectors[2];
  EXPECT_DOUBLE_EQ(span.rest[2], 0.3);
  EXPECT_GT(std::abs(span.rest[0] - 0.3), 1e-4);
  Rope short_one = rope;
  short_one.particles = "2";
  expect(short_one, "particles: found 2, expected at least 3");
}

// A capstan that is driven: its motor feels the difference of what both sides pull with.
TEST_F(PulleyScene, IsDrivenAsItSays) {
  for (const std::string keys : {"passed = [{ t = 0, passed = 0 }, { t = 1, passed = 0.4 }]",
                                 "passed = [{ t = 0, speed = 0 }, { t = 0.4, speed = 0.5 }]"}) {
    SCOPED_TRACE(keys);
    const std::string drum = "[pulleys]\ndrum = { fixed = [0, 2, 0], " + keys + " }\n";
    const World world = read(scene({.over = "[\"drum\"]", .length = "1.6", .eyes = drum})).world;
    EXPECT_TRUE(world.pulleys.empty());
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-8}}));
    simulation.advance_to(0.3);
    const World& now = simulation.world();
    const PaidOut passed = now.connectors[1].winch->paid_out(0, 0.3);
    EXPECT_GT(passed.acceleration, 0.1);
    EXPECT_NEAR(now.connectors[0].length, 0.8 - passed.length, 1e-12);
    EXPECT_NEAR(now.connectors[1].length, 0.8 + passed.length, 1e-12);
    const double density = 0.27 / 1.6, half = density / 2 * passed.rate * passed.rate;
    const double left = (1 + density * now.connectors[0].length) * (9.81 + passed.acceleration);
    const double right = (2 + density * now.connectors[1].length) * (9.81 - passed.acceleration);
    EXPECT_NEAR(winch_tension(now, 0, 1), left, 1e-9 * left + half * 1e-9);
    EXPECT_NEAR(winch_tension(now, 1, 0), right, 1e-9 * right);
  }
}

TEST_F(PulleyScene, SaysWhatIsWrongWithOneThatIsDriven) {
  const std::string keys = "passed = [{ t = 0, passed = 0 }, { t = 1, passed = 0.4 }]";
  const auto refuses = [&](const std::string& eyes, const std::string& words) {
    expect({.over = "[\"drum\"]", .length = "1.6", .eyes = eyes}, words);
  };
  refuses("[pulleys]\ndrum = { fixed = [0, 2, 0], inertia = 1, " + keys + " }\n", "inertia");
  refuses(
      "[pulleys]\ndrum = { fixed = [0, 2, 0], passed = [{ t = 0, passed = 0 }, { t = 1, "
      "passed = 0.9 }] }\n",
      "takes in 0.9 m, of 0.792 m that it can");
  refuses(
      "[bodies.load]\nmass = 1.0\nshape = { sphere = { diameter = 0.1 } }\nposition = "
      "[0, 2, 0]\n[pulleys]\ndrum = { body = \"load\", " +
          keys + " }\n",
      "needs a place that is fixed or driven");
}

TEST_F(PulleyScene, SaysWhatIsWrong) {
  expect({.over = "[\"left\", \"up\"]"}, "expected the name of a pulley");
  expect({.over = "[\"left\", \"left\"]"}, "which connectors.rope.over[0] passes already");
  expect({.over = "[\"left\"]"}, "pulleys.right: no rope passes it");
  expect({.start = "direction = [0, -1, 0]"}, "needs start.before");
  expect({.length = "1.7"}, "length: found 1.7, expected at least 1.8");
  expect({.from = "fixed = [0, 1, 0]"}, "leaves 0.8 m up to the first pulley, which is 1 m away");
  expect({.from = "fixed = [0, 1.5, 0]", .particles = "2"},
         "a span of one link is 0.8 m long between places that are 0.5 m apart");
  expect({.more = "look = \"chain\""}, "does not go with");
  expect({.more = "taper = [1.0, 0.5]\nbending_stiffness = 1.0"}, "does not go with");
  expect({.method = "springs"},
         "over: the method springs does not follow pulleys, expected one of: direct, truth");
  expect({.more = "[[cuts]]\nt = 0.5\nconnector = \"rope\"\nat = 0.5\n"},
         "has a winch or passes a pulley");
  expect({.eyes = "[pulleys]\nleft = { fixed = [0, 2, 0] }\nright = { fixed = [0, 2, 0] }\n"},
         "is where the pulley before it is");
  expect({.eyes = "[pulleys]\nleft = { fixed = [0, 2, 0], inertia = -1 }\n"}, "inertia");
  expect({.eyes = "[pulleys]\nleft = { fixed = [0, 2, 0], friction = -0.1 }\n"}, "friction");
  expect({.eyes = "[pulleys]\nleft = { fixed = [0, 2, 0], bearing = 1 }\n"}, "bearing");
  std::string many = "[pulleys]\n";
  for (int i = 0; i < 1001; ++i) many += "p" + std::to_string(i) + " = { fixed = [0, 2, 0] }\n";
  expect({.eyes = many}, "pulleys: has 1001 pulleys, expected at most 1000");
  expect({.more = "[bodies.load]\nmass = 1.0\nhangs = [0, -1, 0]\nshape = { sphere = { "
                  "diameter = 0.1 } }\n",
          .eyes = "[pulleys]\nleft = { body = \"load\" }\nright = { fixed = [1, 2, 0] }\n"},
         "is of a body that hangs");
  expect({.over = "[\"left\"]",
          .more = "[bodies.load]\nmass = 1.0\nposition = [0, 2, 0]\nshape = { sphere = { "
                  "diameter = 0.1 } }\n",
          .eyes = "[pulleys]\nleft = { body = \"load\", friction = 0.1 }\n"},
         "needs a rope without mass on a free body");
}

}  // namespace
}  // namespace taut::pulley_scene_test
