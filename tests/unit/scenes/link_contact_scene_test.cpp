// Scenes whose links touch obstacles: which methods take them.
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

}  // namespace
}  // namespace taut::link_contact_scene_test
