// Choreographies in scene files: what they are read as, and what is said against them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/scenes/scene_texts.h"

namespace taut::choreographed_test {
namespace {

constexpr const char* kCircle =
    "curves = [{ figure = \"circle\", from = 1.0, until = 2.2, laps = 2, centre = [0, 1, 0], "
    "across = [0.2, 0, 0], up = [0, 0, -0.2], to = { centre = [0, 1.2, 0] } }]";

std::string scene(const std::string& goal, const std::string& more = "body = \"free\"",
                  const std::string& keys = "{ t = 0.5, position = [0, 2, 0] }") {
  return "duration = 4.0\n[paths.hand]\nkeys = [{ t = 0.0, position = [0, 2, 0] }, " + keys +
         "]\n[bodies.free]\nmass = 0.1\nshape = { cylinder = { length = 0.3, diameter = 0.03 } }\n"
         "hangs = [0, -1, 0]\n[connectors.chain]\nlength = 0.1\nmass = 0.01\nparticles = 5\n"
         "from = { path = \"hand\" }\nto = { body = \"free\", point = [0, 0.15, 0] }\n"
         "[choreography]\npath = \"hand\"\nfile = \"hand.csv\"\nuntil = 3.0\n" +
         more + "\n" + goal + "\n";
}

class ChoreographedScene : public SceneTexts {
 protected:
  scenes::Choreographed asked(const std::string& text) const {
    return scenes::load_choreography(folder_.write("scene.toml", text)).value();
  }
  void keys_at(const std::string& times) const {
    std::string text = "t,x,y,z\n";
    for (std::size_t from = 0; from < times.size();) {
      const std::size_t end = std::min(times.find(' ', from), times.size());
      text += times.substr(from, end - from) + ",0.1,2,0\n";
      from = end + 1;
    }
    folder_.write("hand.csv", text);
  }
};

TEST_F(ChoreographedScene, CurvesAreWaypoints) {
  const scenes::Choreographed made = asked(scene(kCircle));
  const auto& points = made.problem.waypoints;
  ASSERT_EQ(points.size(), 13u);
  EXPECT_LT((points[0].position - Vec3(0, 1, 0.2)).norm(), 1e-15);  // centre - up
  EXPECT_DOUBLE_EQ(points[6].time, 1.6);
  EXPECT_LT((points[6].position - Vec3(0, 1.1, 0.2)).norm(), 1e-15);
  EXPECT_LT((points[3].position - Vec3(0, 1.05, -0.2)).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(points[12].time, 2.2);
  EXPECT_EQ(made.file.filename(), "hand.csv");
  EXPECT_EQ(made.problem.until, 3);
}

TEST_F(ChoreographedScene, AnEightCrossesItsMiddle) {
  const auto points =
      asked(scene("curves = [{ figure = \"eight\", from = 1.0, until = 1.8, laps = 1, centre = "
                  "[0, 1, 0], across = [0.2, 0, 0], up = [0, 0.1, 0] }]"))
          .problem.waypoints;
  ASSERT_EQ(points.size(), 9u);
  EXPECT_LT((points[4].position - Vec3(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((points[1].position - Vec3(std::sqrt(0.02), 1.1, 0)).norm(), 1e-15);
  EXPECT_LT((points[2].position - Vec3(0.2, 1, 0)).norm(), 1e-15);
}

TEST_F(ChoreographedScene, TheKeysFoundStandBetweenThePaths) {
  keys_at("1.0 2.0 3.0");
  const std::string later = "{ t = 0.5, position = [0, 2, 0] }, { t = 3.5, position = [0, 1, 0] }";
  const scenes::Scene made = read(scene(kCircle, "body = \"free\"", later));
  const auto& keys = made.world.connectors[0].holds[0].to.path->keys();
  ASSERT_EQ(keys.size(), 6u);
  EXPECT_TRUE(keys[1].ease);
  EXPECT_EQ(keys[2].time, 1);
  EXPECT_TRUE(keys[4].ease);
  EXPECT_EQ(keys[5].time, 3.5);
  // What is looked for begins where the path's own keys end.
  EXPECT_EQ(asked(scene(kCircle, "body = \"free\"", later))
                .problem.world.connectors[0]
                .holds[0]
                .to.path->keys()
                .size(),
            2u);
}

TEST_F(ChoreographedScene, FaultsAreNamed) {
  const std::string point = "waypoints = [{ t = 1.0, position = [0, 1.8, 0] }]";
  expect(scene(point), "choreography.file: there is no file \"hand.csv\"");
  keys_at("1.0 3.0");
  EXPECT_EQ(said(scene(point)), "nothing");
  expect(scene(""), "choreography: has neither waypoints nor curves");
  expect(scene(point, "body = \"other\""), "choreography.body: found \"other\"");
  expect(scene(point, "body = \"free\"\npoint = [0.1, 0, 0]"),
         "expected a point on the line through where the body hangs");
  expect(scene("waypoints = [{ t = 3.0, position = [0, 1, 0] }]"),
         "choreography.until: found 3, expected a time after 3 s");
  expect(scene("waypoints = [{ t = 1.0, position = [0, 1, 0] }, { t = 1.0, position = [0, 2, 0] "
               "}]"),
         "is to be in two places at 1 s");
  expect(scene(point, "body = \"free\"", "{ t = 2.0, position = [0, 2, 0] }"),
         "expected one key before and none there");
  expect(scene("waypoints = [{ t = 0.0, position = [0, 1, 0] }]", "body = \"free\"",
               "{ t = 3.5, position = [0, 2, 0] }"),
         "stands among the choreography");
  expect(scene("waypoints = [{ t = 1.0, position = [0, 1, 0] }, { t = 1.0001, position = [0, 2, 0] "
               "}]"),
         "takes a curve of ");
  expect(scene(point + "\nlimits = { shoulder = [0, 1, 0], clearance = 0.1 }"),
         "needs choreography.pivot");
  std::string brief = scene(point);
  brief.replace(brief.find("until = 3.0"), 11, "until = 1.1");
  expect(brief, "choreography.until: found 1.1, expected more time");
  keys_at("1.0 0.5");
  expect(scene(point), "hand.csv:3: found the time 0.5, expected one after 1");
}

}  // namespace
}  // namespace taut::choreographed_test
