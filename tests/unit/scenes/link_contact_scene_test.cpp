// Scenes whose links touch obstacles or each other: what is read, and which methods take them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/run/method.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::link_contact_scene_test {
namespace {

/// With the method and what the rope's last end is.
constexpr const char* kLinks = R"(duration = 1.0
[method]
name = "{}"
[connectors.rope]
length = 1.0
mass = 0.1
particles = 21
radius = 0.01
contact = "links"
from = {{ fixed = [0, 1, 0] }}
to = {{ {} }}
start = {{ direction = [1, 0, 0] }}
[obstacles.floor]
shape = {{ plane = {{}} }}
[bodies.ball]
mass = 1
shape = {{ sphere = {{ diameter = 0.1 }} }}
position = [1, 1, 0]
)";

class LinkContactScene : public SceneTexts {};

TEST_F(LinkContactScene, IsReadWhereTheMethodFollowsIt) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || !method.abilities.follows.has(Feature::obstacle)) continue;
    const std::string text = fmt::format(kLinks, method.name, "free = true");
    if (method.abilities.follows.has(Feature::links_touch)) {
      EXPECT_TRUE(has_touching_links(read(text).world)) << method.name;
    } else {
      expect(text, fmt::format("the method {} does not follow capsule links, expected one of: "
                               "springs, xpbd, direct",
                               method.name));
    }
  }
}

TEST_F(LinkContactScene, IsReadWhereTheMethodFollowsItAtBodies) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || !method.abilities.follows.has(Feature::links_touch)) continue;
    const std::string text = fmt::format(kLinks, method.name, "body = \"ball\"");
    EXPECT_TRUE(has_touching_links(read(text).world)) << method.name;
  }
}

constexpr const char* kRopes = R"(duration = 1.0
[connectors.high]
length = 1.0
mass = 0.1
particles = 21
radius = 0.01
from = { fixed = [0, 1, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
[connectors.low]
length = 1.0
mass = 0.1
particles = 21
radius = 0.02
from = { fixed = [0, 0.5, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
repeat = [{ count = 2, by = [0, -0.2, 0] }]
)";

TEST_F(LinkContactScene, ConnectorsTouchAsTheSceneSays) {
  const World both = read(kRopes + std::string("[touching.all]\nconnectors = [\"high\", \"low\"]\n"
                                               "friction = 0.3\nrestitution = 0.1\n"))
                         .world;
  ASSERT_EQ(both.connector_pairs.size(), 2u);  // with either copy; the copies pass each other
  for (const ConnectorPair& pair : both.connector_pairs) {
    EXPECT_NE(pair.a == 0, pair.b == 0);
    EXPECT_EQ(pair.kinetic_friction, 0.3);
    EXPECT_EQ(pair.restitution, 0.1);
  }
  const World own = read(kRopes + std::string("touches_itself = true\nfriction = 0.2\n")).world;
  EXPECT_EQ(own.connector_pairs.size(), 3u);  // each copy itself, and both
  EXPECT_TRUE(has_contact(own));
}

TEST_F(LinkContactScene, FaultsOfConnectorsThatTouchAreNamed) {
  const auto touch = [](const std::string& names, const std::string& keys = "") {
    return kRopes + keys + "[touching.all]\nconnectors = [" + names + "]\n";
  };
  expect(touch("\"high\""), "expected bodies, or at least two connectors");
  expect(touch("\"high\", \"none\""), "touching.all.connectors");
  expect(touch("\"high\", \"high\""), "is there twice");
  expect(touch("\"high\", \"low\"", "friction = 0.2\n"), "needs touches_itself = true");
  std::string thin = touch("\"high\", \"low\"");
  thin.replace(thin.find("radius = 0.02"), 13, "radius = 0.00");
  expect(thin, "whose radius is 0, expected one above 0");
  std::string inside = touch("\"high\", \"low\"");
  inside.replace(inside.find("[0, 0.5, 0]"), 11, "[0, 0.98, 0]");
  expect(inside, "m inside of link");
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || method.abilities.follows.has(Feature::connector_pairs)) continue;
    expect(
        touch("\"high\", \"low\"", "[method]\nname = \"" + std::string(method.name) + "\"\n"),
        "the method " + std::string(method.name) +
            " does not follow contact between connectors, expected one of: springs, xpbd, direct");
  }
}

}  // namespace
}  // namespace taut::link_contact_scene_test
