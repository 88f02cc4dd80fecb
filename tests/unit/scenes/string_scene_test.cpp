// Connectors of strings in scenes: what they are read as, and what is said against them.
#include <gtest/gtest.h>

#include "sim/interventions/interventions.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::string_scene_test {
namespace {

std::string string_with(const std::string& keys, const std::string& method = "direct") {
  return "duration = 1.0\n[method]\nname = \"" + method +
         "\"\n[connectors.string]\nlength = 2.0\nmass = 1.0\nparticles = 5\n"
         "from = { fixed = [0, 1, 0] }\nto = { free = true }\n" +
         keys + "\n";
}

const std::string kPull = "links = \"pull\"\n";

class StringScene : public SceneTexts {
 protected:
  World read(const std::string& text) const { return SceneTexts::read(text).world; }
};

TEST_F(StringScene, IsReadAsItSays) {
  EXPECT_TRUE(has_strings(read(string_with(kPull))));
  EXPECT_FALSE(has_strings(read(string_with("links = \"rigid\""))));
  EXPECT_FALSE(has_strings(read(string_with(""))));
  EXPECT_NE(read(string_with(kPull)).topology, read(string_with("")).topology);
}

// Evenly, where the line is shorter; else with its links at their length.
TEST_F(StringScene, StartsAsShortAsItsLine) {
  const std::string start = "start = { points = [[0, 1, 0], [0.6, 1, 0], [0.6, 1.4, 0]] }";
  const std::vector<Vec3> at = read(string_with(kPull + start)).connectors[0].position;
  ASSERT_EQ(at.size(), 5u);
  const Vec3 expected[] = {{0, 1, 0}, {0.25, 1, 0}, {0.5, 1, 0}, {0.6, 1.15, 0}, {0.6, 1.4, 0}};
  for (std::size_t i = 0; i < 5; ++i) EXPECT_LT((at[i] - expected[i]).norm(), 1e-12) << i;
  const std::string straight = "start = { points = [[0, 1, 0], [3, 1, 0]] }";
  EXPECT_LT((read(string_with(kPull + straight)).connectors[0].position[4] - Vec3(2, 1, 0)).norm(),
            1e-12);
  expect(string_with(start), "has room for");
}

TEST_F(StringScene, FaultsAreNamed) {
  expect(string_with("links = \"push\""), "rigid");
  std::string span = string_with(kPull + "model = \"span\"");
  expect(span, "needs model = \"links\"");
  expect(string_with(kPull + "bending_stiffness = 1", "xpbd"),
         "bending_stiffness: the method xpbd does not follow bending together with strings");
}

TEST_F(StringScene, OtherMethodsAreRefused) {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty()) continue;
    const std::string text = string_with(kPull, std::string(method.name));
    if (method.abilities.follows.has(Feature::strings)) {
      EXPECT_TRUE(has_strings(read(text))) << method.name;
    } else {
      expect(text, "the method " + std::string(method.name) +
                       " does not follow strings, expected one of: springs, xpbd, direct, truth");
    }
  }
}

// The part cut off is of strings as well.
TEST_F(StringScene, StaysOneWhenCut) {
  World world = read(string_with(kPull));
  Interventions interventions;
  interventions.cut(world, 0, 0.7);
  ASSERT_EQ(world.connectors.size(), 2u);
  EXPECT_TRUE(world.connectors[0].pulls && world.connectors[1].pulls);
}

}  // namespace
}  // namespace taut::string_scene_test
