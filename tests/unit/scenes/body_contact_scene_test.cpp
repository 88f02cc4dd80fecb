// Free bodies that touch obstacles, in scenes: what they are read as, and what is said against
// them.
#include <gtest/gtest.h>

#include "sim/run/method.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::body_contact_scene_test {
namespace {

const std::string kStick = "shape = { cylinder = { length = 0.3, diameter = 0.02 } }\n";
const std::string kAbove = "position = [0, 1, 0]\n";

std::string stick_with(const std::string& keys, const std::string& method = "direct") {
  return "duration = 1.0\n[method]\nname = \"" + method + "\"\n[bodies.stick]\nmass = 0.1\n" +
         keys + "\n[obstacles.floor]\nshape = { plane = {} }\n";
}

class BodyContactScene : public SceneTexts {
 protected:
  World read(const std::string& text) const { return SceneTexts::read(text).world; }
};

TEST_F(BodyContactScene, IsReadAsItSays) {
  EXPECT_FALSE(has_touching_bodies(read(stick_with(kStick + kAbove))));
  const World world = read(stick_with(kStick + kAbove + "contact = {}"));
  EXPECT_TRUE(has_touching_bodies(world));
  const BodyCapsule& fits = world.bodies[0].capsule;
  EXPECT_DOUBLE_EQ(fits.radius, 0.01);
  EXPECT_LT((fits.from + 0.14 * Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((fits.to - 0.14 * Vec3::UnitY()).norm(), 1e-15);
  const BodyCapsule ball =
      read(stick_with("shape = { sphere = { diameter = 0.1 } }\ncontact = {}\n" + kAbove))
          .bodies[0]
          .capsule;
  EXPECT_DOUBLE_EQ(ball.radius, 0.05);
  EXPECT_TRUE(ball.from.isZero(0) && ball.to.isZero(0));
  const BodyCapsule own = read(stick_with("inertia = [1, 1, 1]\n" + kAbove +
                                          "contact = { radius = 0.02, from = [0, -0.1, 0], "
                                          "to = [0.1, 0.2, 0] }"))
                              .bodies[0]
                              .capsule;
  EXPECT_EQ(own.to, Vec3(0.1, 0.2, 0));
  EXPECT_DOUBLE_EQ(own.radius, 0.02);
}

TEST_F(BodyContactScene, FaultsAreNamed) {
  const std::string box = "shape = { box = { size = [1, 1, 1] } }\nposition = [0, 9, 0]\n";
  expect(stick_with(box + "contact = {}"), "bodies.stick.contact: radius is missing");
  expect(stick_with(box + "contact = { radius = 1 }"), "from and to are missing");
  expect(stick_with(box + "contact = { radius = 1, to = [0, 1, 0] }"), "needs from");
  expect(stick_with(box + "contact = { radius = 0, from = [0, 0, 0], to = [0, 1, 0] }"),
         "contact.radius");
  expect(stick_with(kStick + kAbove + "contact = { radius = 0.2 }"),
         "which a cylinder shorter than 0.4 m gives no line");
  expect(stick_with(kStick + "position = [0, 0.1, 0]\ncontact = {}"),
         "bodies.stick.contact: starts 0.05 m inside of obstacle floor");
  expect(stick_with(kStick + "contact = {}\ndriven_by = { path = \"hand\" }\n"
                             "[paths.hand]\nkeys = [{ t = 0, position = [0, 1, 0] }]"),
         "needs a free body, without driven_by");
}

TEST_F(BodyContactScene, OtherMethodsAreRefused) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    const std::string text = stick_with(kStick + kAbove + "contact = {}", std::string(method.name));
    if (method.abilities.follows.has(Feature::body_contact)) {
      EXPECT_TRUE(follows(method, read(text))) << method.name;
    } else {
      expect(text, method.abilities.follows.has(Feature::obstacle)
                       ? "does not follow contact of bodies with obstacles"
                       : "does not follow obstacles");
    }
  }
}

/// Three sticks side by side, and what else stands in the scene.
std::string sticks_with(const std::string& keys, const std::string& method = "direct") {
  std::string text = "duration = 1.0\n[method]\nname = \"" + method + "\"\n";
  for (int i = 0; i < 3; ++i) {
    text += "[bodies.s" + std::to_string(i) + "]\nmass = 0.1\n" + kStick + "position = [" +
            std::to_string(i) + ", 0, 0]\ncontact = {}\n";
  }
  return text + "[bodies.led]\nmass = 0.1\n" + kStick +
         "driven_by = { path = \"hand\" }\n[bodies.bare]\nmass = 0.1\n" + kStick +
         "position = [9, 0, 0]\n[paths.hand]\nkeys = [{ t = 0, position = [0, 1, 0] }]\n" + keys;
}

const std::string kAll = "[touching.sticks]\nbodies = [\"s0\", \"s1\", \"s2\"]\n";

TEST_F(BodyContactScene, PairsAreReadAsTheySay) {
  EXPECT_TRUE(read(sticks_with("")).pairs.empty());
  const World world =
      read(sticks_with(kAll + "friction = 0.2\nstatic_friction = 0.3\nrestitution = 0.4"));
  ASSERT_EQ(world.pairs.size(), 3u);
  EXPECT_EQ(world.pairs[1].a, 0u);
  EXPECT_EQ(world.pairs[1].b, 2u);
  EXPECT_DOUBLE_EQ(world.pairs[1].kinetic_friction, 0.2);
  EXPECT_DOUBLE_EQ(world.pairs[1].static_friction, 0.3);
  EXPECT_DOUBLE_EQ(world.pairs[1].restitution, 0.4);
  EXPECT_TRUE(has_touching_bodies(world));
  std::string ignoring = sticks_with(kAll);
  ignoring.replace(ignoring.find("contact = {}"), 12, "contact = { ignores = [\"s2\"] }");
  const World fewer = read(ignoring);
  ASSERT_EQ(fewer.pairs.size(), 2u);
  EXPECT_EQ(fewer.pairs[0].b, 1u);
  EXPECT_EQ(fewer.pairs[1].a, 1u);
}

TEST_F(BodyContactScene, FaultsOfPairsAreNamed) {
  const auto of = [](const std::string& names) {
    return sticks_with("[touching.sticks]\nbodies = [" + names + "]");
  };
  expect(of("\"s0\""), "touching.sticks.bodies: found");
  expect(of("\"s0\", \"s0\""), "is there twice");
  expect(of("\"s0\", \"none\""), "none");
  std::string many = "\"s0\"";
  for (int i = 1; i < 500; ++i) many += ", \"s0\"";
  expect(of(many), "makes more than 100000 pairs");
  expect(of("\"s0\", \"led\""), "expected a free body");
  expect(of("\"s0\", \"bare\""), "expected a body with contact");
  expect(sticks_with(kAll + "[touching.more]\nbodies = [\"s2\", \"s1\"]"),
         "has s1 and s2, which are in touching.sticks already");
  expect(sticks_with(kAll + "friction = 0.2\nstatic_friction = 0.1"), "at least friction, 0.2");
  std::string inside = sticks_with(kAll);
  inside.replace(inside.find("[1, 0, 0]"), 9, "[0.01, 0, 0]");
  expect(inside, "bodies.s1.contact: starts 0.01 m inside of body s0");
  const auto rope = [](const std::string& keys, const std::string& method = "direct") {
    return sticks_with(kAll +
                           "[connectors.rope]\nlength = 1.0\nfrom = { fixed = [5, 5, 0] }\n"
                           "to = { free = true }\n" +
                           keys,
                       method);
  };
  EXPECT_EQ(said(rope("mass = 0\nparticles = 2\nmodel = \"span\"")), "nothing");
  EXPECT_EQ(said(rope("mass = 0.1\nparticles = 9\naxial_stiffness = 10.0", "truth")), "nothing");
}

const std::string kNetBelow =
    "[nets.net]\nkind = \"net\"\norigin = [-0.5, -1, -0.5]\nacross = [1, 0, 0]\n"
    "down = [0, 0, 1]\nsize = [1, 1]\ncells = [2, 2]\nmass = 0.1\nheld = \"nothing\"\n"
    "diameter = 0.02\n";

std::string beads_touch(const std::string& connectors, const std::string& bodies = "\"s0\"") {
  return "[touching.both]\nbodies = [" + bodies + "]\nconnectors = [" + connectors +
         "]\nfriction = 0.2\nrestitution = 0.3\n";
}

TEST_F(BodyContactScene, BeadsTouchBodiesAsTheSceneSays) {
  const World world =
      read(sticks_with(kNetBelow + beads_touch("\"net\"", "\"s0\", \"s2\""), "xpbd"));
  EXPECT_EQ(world.pairs.size(), 1u);
  ASSERT_EQ(world.bead_pairs.size(), 2 * world.connectors.size());
  EXPECT_EQ(world.bead_pairs[1].connector, 0u);
  EXPECT_EQ(world.bead_pairs[1].body, 2u);
  EXPECT_DOUBLE_EQ(world.bead_pairs[1].kinetic_friction, 0.2);
  EXPECT_DOUBLE_EQ(world.bead_pairs[1].restitution, 0.3);
  EXPECT_TRUE(has_contact(world));
}

TEST_F(BodyContactScene, FaultsOfBeadsThatTouchBodiesAreNamed) {
  expect(sticks_with(kNetBelow + beads_touch("\"none\""), "xpbd"), "touching.both.connectors");
  expect(sticks_with(kNetBelow + beads_touch("\"net\", \"net\""), "xpbd"),
         "has net#1 and s0, which are in touching.both already");
  expect(sticks_with(kNetBelow + beads_touch("\"net\"", ""), "xpbd"), "touching.both.bodies");
  std::string inside = sticks_with(kNetBelow + beads_touch("\"net\""), "xpbd");
  inside.replace(inside.find("[-0.5, -1, -0.5]"), 16, "[-0.5, 0.0, -0.5]");
  expect(inside, "nets.net: its particle");
  for (const MethodInfo& method : all_methods()) {
    if (!method.abilities.follows.has(Feature::body_contact) ||
        method.abilities.follows.has(Feature::bead_pairs))
      continue;
    expect(sticks_with(kNetBelow + beads_touch("\"net\""), std::string(method.name)),
           "touching.both.connectors: the method " + std::string(method.name) +
               " does not follow contact of beads with bodies, expected one of: springs, xpbd");
  }
}

TEST_F(BodyContactScene, JoinedConnectorsTouchObstaclesInSomeMethods) {
  const std::string floor = "[obstacles.floor]\nshape = { plane = {} }\nposition = [0, -2, 0]\n";
  EXPECT_EQ(read(sticks_with(kNetBelow + floor, "springs")).obstacles.size(), 1u);
  EXPECT_EQ(read(sticks_with(kNetBelow + floor, "direct")).obstacles.size(), 1u);
  EXPECT_EQ(read(sticks_with(kNetBelow + floor, "truth")).obstacles.size(), 1u);
  expect(sticks_with(kNetBelow + "[obstacles.floor]\nshape = { plane = {} }\n"
                                 "position = [0, -0.5, 0]\nignores = [\"s0\", \"s1\", \"s2\"]",
                     "springs"),
         "nets.net: its particle");
}

TEST_F(BodyContactScene, OtherMethodsAreRefusedWithPairs) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    const std::string text = sticks_with(kAll, std::string(method.name));
    if (method.abilities.follows.has(Feature::body_contact)) {
      EXPECT_TRUE(follows(method, read(text))) << method.name;
    } else {
      expect(
          text,
          "does not follow contact between bodies, expected one of: springs, xpbd, direct, truth");
    }
  }
}

}  // namespace
}  // namespace taut::body_contact_scene_test
