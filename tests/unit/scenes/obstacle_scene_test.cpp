// Obstacles of scenes: what they are read as, what is said against them, and how they are seen.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/load/faults.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::obstacle_scene_test {
namespace {

constexpr const char* kScene = R"(duration = 1.0
[connectors.rope]
length = 1.0
mass = 0.1
particles = 21
radius = 0.01
from = { fixed = [0, 1, 0] }
to = { free = true }
start = { direction = [1, 0, 0] }
[obstacles.floor]
shape = { plane = {} }
friction = 0.4
)";

class ObstacleScene : public SceneTexts {
 protected:
  /// The message on the scene with `more` behind it.
  std::string said(const std::string& more, const std::string& scene = kScene) const {
    return SceneTexts::said(scene + more);
  }
  void expect(const std::string& more, const std::string& place, const std::string& words) const {
    SceneTexts::expect(kScene + more, "scene.toml:" + place);
    SceneTexts::expect(kScene + more, words);
  }
};

TEST_F(ObstacleScene, IsReadAsItSays) {
  const scenes::Scene scene = read(std::string(kScene) + R"([paths.hand]
keys = [{ t = 0, position = [0, 0, 5] }, { t = 1, position = [1, 0, 5] }]
[obstacles.post]
shape = { cylinder = { length = 2, diameter = 0.1, rounding = 0.02 } }
path = "hand"
position = [0, 1, 0]
rotation = [0, 1, 0, 0]
static_friction = 0.5
friction = 0.2
restitution = 0.3
)",
                                   true);
  ASSERT_EQ(scene.world.obstacles.size(), 2u);
  const Obstacle &floor = scene.world.obstacles[0], &post = scene.world.obstacles[1];
  EXPECT_EQ(floor.shape.kind, Shape::Kind::plane);
  EXPECT_EQ(floor.kinetic_friction, 0.4);
  EXPECT_EQ(floor.static_friction, 0.4);
  EXPECT_EQ(floor.restitution, 0);
  EXPECT_EQ(post.shape.radius, 0.05);
  EXPECT_EQ(post.shape.rounding, 0.02);
  EXPECT_EQ(post.static_friction, 0.5);
  EXPECT_EQ(post.kinetic_friction, 0.2);
  EXPECT_EQ(post.restitution, 0.3);
  EXPECT_EQ(post.frame(1).position, Vec3(1, 1, 5));
  EXPECT_EQ(scene.world.connectors[0].radius, 0.01);
  // An obstacle that moves is seen by a driven body.
  ASSERT_EQ(scene.world.bodies.size(), 1u);
  EXPECT_EQ(scene.world.bodies[0].name, "post");
  EXPECT_TRUE(scene.world.bodies[0].driven());
}

TEST_F(ObstacleScene, IsSeen) {
  const scenes::Scene scene = read(std::string(kScene) + R"([paths.hand]
keys = [{ t = 0, position = [0, 0, 5] }, { t = 1, position = [1, 0, 5] }]
[obstacles.ball]
shape = { sphere = { diameter = 0.2 } }
path = "hand"
position = [0, 1, 0]
[obstacles.bar]
shape = { capsule = { length = 1, diameter = 0.1 } }
position = [0, 0, -3]
[obstacles.step]
shape = { box = { size = [1, 0.2, 1], rounding = 0.02 } }
position = [3, 0, 0]
[stage]
)",
                                   true);
  ASSERT_TRUE(scene.stage);
  ASSERT_EQ(scene.stage->scenery.size(), 3u);  // floor, bar and step
  ASSERT_EQ(scene.stage->body_models.size(), 1u);
  // The vertices of each lie on its surface, and normals are those of the surface.
  std::size_t seen = 0;
  for (const Obstacle& obstacle : scene.world.obstacles) {
    const scenes::Model& model =
        obstacle.path ? *scene.stage->body_models[0] : *scene.stage->scenery[seen++];
    const Pose place = obstacle.place;
    for (const scenes::Vertex& vertex : model.meshes[0].vertices) {
      const Vec3 at(double(vertex.position[0]), double(vertex.position[1]),
                    double(vertex.position[2]));
      const Vec3 normal(double(vertex.normal[0]), double(vertex.normal[1]),
                        double(vertex.normal[2]));
      EXPECT_NEAR(gap(obstacle, place, at, 0).distance, 0, 1e-6) << obstacle.name;
      EXPECT_GT(gap(obstacle, place, at + 1e-3 * normal, 0).normal.dot(normal), 0.999)
          << obstacle.name;
    }
    // Triangles face outwards.
    const std::vector<scenes::Vertex>& vertices = model.meshes[0].vertices;
    const auto at = [&](std::uint32_t index) {
      const auto& p = vertices[index].position;
      return Vec3(double(p[0]), double(p[1]), double(p[2]));
    };
    const std::vector<std::uint32_t>& indices = model.meshes[0].indices;
    double area = 0;
    for (std::size_t i = 0; i < indices.size(); i += 3) {
      const Vec3 a = at(indices[i]), b = at(indices[i + 1]), c = at(indices[i + 2]);
      const auto& n = vertices[indices[i]].normal;
      const Vec3 cross = (b - a).cross(c - a);
      area += cross.norm() / 2;
      if (cross.norm() < 1e-9) continue;
      EXPECT_GT(cross.dot(Vec3(double(n[0]), double(n[1]), double(n[2]))), 0) << obstacle.name;
    }
    const double pi = 3.14159265;
    if (obstacle.name == "ball") {
      EXPECT_NEAR(area, 4 * pi * 0.01, 0.01 * area);
    } else if (obstacle.name == "bar") {
      EXPECT_NEAR(area, pi * 0.1 + 4 * pi * 0.0025, 0.01 * area);
    } else if (obstacle.name == "step") {
      // Faces, edges and corners of a box of 0.96 x 0.16 x 0.96 with everything 0.02 from it.
      const double faces = 2 * (0.96 * 0.96 + 2 * 0.96 * 0.16);
      const double edges = 2 * pi * 0.02 * (0.96 + 0.16 + 0.96), corners = 4 * pi * 0.0004;
      EXPECT_NEAR(area, faces + edges + corners, 1e-3 * area);
    }
  }
}

constexpr const char* kPlayer = R"([paths.right_hand]
keys = [{ t = 0, position = [-0.262, 1.037, 0.498], axis = [-1, 0, 0] },
        { t = 1, position = [-0.262, 1.337, 0.398] }]
[characters.player]
mesh = "player.glb"
right_hand = "right_hand"
)";  // The bone carries it, and its capsule has the skin that moves with the bone inside.
TEST_F(ObstacleScene, ABoneCarriesIt) {
  folder_.write("player.glb", read_file(TAUT_SOURCE_DIR "/assets/martial_artist.glb"));
  const scenes::Scene scene = read(std::string(kScene) + kPlayer + R"([obstacles.arm]
character = "player"
bone = "RightForeArm"
[obstacles.eye]
character = "player"
bone = "LeftEye"
[obstacles.cuff]
character = "player"
bone = "RightForeArm"
shape = { sphere = { diameter = 0.05 } }
position = [0, 0.1, 0]
[stage]
)",
                                   true);
  ASSERT_TRUE(scene.stage);
  ASSERT_EQ(scene.world.obstacles.size(), 4u);
  const Obstacle &arm = scene.world.obstacles[1], &cuff = scene.world.obstacles[3];
  EXPECT_TRUE(scene.world.obstacles[2].place.rotation.coeffs().allFinite());  // nearly a ball
  EXPECT_TRUE(scene.world.bodies.empty());  // pictures show the skin
  ASSERT_TRUE(arm.path);
  EXPECT_EQ(arm.path, cuff.path);
  const FrameMotion bone = arm.path->at(0.5);
  EXPECT_EQ(cuff.frame(0.5).position, bone.point(Vec3(0, 0.1, 0)).position);
  EXPECT_EQ(arm.shape.kind, Shape::Kind::capsule);
  // Of the skin of that bone nearly all lies within the capsule, and some at its surface.
  const scenes::Model& model = *scene.stage->characters[0];
  const auto named = [](const scenes::Bone& b) { return b.name == "RightForeArm"; };
  const auto index =
      static_cast<std::size_t>(std::ranges::find_if(model.bones, named) - model.bones.begin());
  const Eigen::Affine3d bind(model.bones[index].inverse_bind.cast<double>());
  std::size_t of_bone = 0, inside = 0;
  double nearest = 1;
  for (const scenes::Mesh& mesh : model.meshes) {
    for (const scenes::Vertex& v : mesh.vertices) {
      const auto strongest = std::ranges::max_element(v.weights);
      const auto k = static_cast<std::size_t>(strongest - v.weights.begin());
      if (!(*strongest > 0) || v.bones[k] != index) continue;
      const Vec3 at = bind * Vec3(v.position[0], v.position[1], v.position[2]);
      const double apart = gap(arm, arm.place, at, 0).distance;
      ++of_bone;
      inside += apart < 0;
      nearest = std::min(nearest, std::abs(apart));
    }
  }
  ASSERT_GT(of_bone, 100u);
  EXPECT_GT(static_cast<double>(inside), 0.9 * static_cast<double>(of_bone));
  EXPECT_LT(nearest, 0.002);
}

// A driven body carries it by its grip.
TEST_F(ObstacleScene, ABodyCarriesIt) {
  const std::string club = R"([paths.hand]
keys = [{ t = 0, position = [0, 0, 5] }, { t = 1, position = [1, 0, 5] }]
[bodies.club]
mass = 1
shape = { cylinder = { length = 1, diameter = 0.1 } }
driven_by = { path = "hand" }
grip = [0, 0.4, 0]
)";
  const scenes::Scene scene = read(std::string(kScene) + club + R"([obstacles.club]
body = "club"
shape = { cylinder = { length = 1, diameter = 0.1 } }
position = [0, 0.1, 0]
)");
  ASSERT_EQ(scene.world.bodies.size(), 1u);  // which is seen already
  EXPECT_TRUE(scene.world.obstacles[1].frame(1).position.isApprox(Vec3(1, -0.3, 5), 1e-15));
}

TEST_F(ObstacleScene, FaultsOfWhatCarriesItAreNamed) {
  const std::string ball = "[obstacles.ball]\nshape = { sphere = { diameter = 0.2 } }\n";
  expect(ball +
             "body = \"club\"\n[bodies.club]\nmass = 1\nshape = { sphere = { diameter = 1 } }\n"
             "position = [0, 0, 5]\n",
         "15:8", "found \"club\", expected a driven body: free ones carry no obstacle");
  expect(ball + "path = \"hand\"\nbone = \"Head\"\n", "16:1",
         "stands beside path, expected only one of: path, body, bone");
  expect(ball + "bone = \"Head\"\n", "15:1", "needs character");
  expect(ball + "character = \"player\"\n" + kPlayer, "15:1", "needs bone");
  const std::string bare = "[obstacles.arm]\ncharacter = \"player\"\nbone = \"Head\"\n";
  expect(bare + "position = [0, 1, 0]\n" + kPlayer, "16:1", "needs shape");
  expect("[obstacles.arm]\nfriction = 1\n", "13:", "shape is missing");
}

TEST_F(ObstacleScene, IgnoresWhatItNames) {
  const std::string start = "start = { direction = [1, 0, 0] }\n";
  std::string scene = kScene;
  scene.insert(scene.find(start) + start.size(),
               "[connectors.cord]\nlength = 1\nparticles = 5\nmass = 0.1\nrepeat = [{ count = 2, "
               "by = [0, 0, 1] }]\nfrom = { fixed = [0, -1, 0] }\nto = { free = true }\n");
  const World world = read(scene + "ignores = [\"cord\"]\n").world;
  ASSERT_EQ(world.connectors.size(), 3u);
  for (const Connector& connector : world.connectors) {
    EXPECT_EQ(world.obstacles[0].touches(connector.category), connector.name == "rope")
        << connector.name;
  }
  expect("ignores = [\"rod\"]\n", "13:12",
         "obstacles.floor.ignores[0]: found \"rod\", expected the name of a connector, net or free "
         "body");
  expect("ignores = \"rope\"\n", "13:11", "expected a list of strings");
}

TEST_F(ObstacleScene, FaultsAreNamed) {
  expect("restitution = 1.5\n", "13:15", "found 1.5, expected a number from 0 to 1");
  expect("static_friction = 0.1\n", "13:19", "found 0.1, expected at least friction, 0.4");
  expect("static_friction = -0.1\n", "13:19", "found -0.1, expected a number");
  expect("[obstacles.ball]\nshape = { ball = { diameter = 1 } }\n", "14:11",
         "expected one of: plane, sphere, capsule, cylinder, box");
  expect(
      "[obstacles.ball]\nshape = { box = { size = [1, 0.1, 1], rounding = 0.06 } }\n"
      "position = [0, 5, 0]\n",
      "14:", "found 0.06, expected at most half of its smallest size, 0.05");
  expect("[obstacles.ball]\nshape = { sphere = { diameter = 0.2 } }\npath = \"hand\"\n", "15:8",
         "expected the name of a path, the scene has none");
  expect("[obstacles.ball]\nshape = { sphere = { diameter = 0.2 } }\nposition = [0, 1, 0]\n",
         "13:", "is around what holds connector rope (particle 0), 0.1 m deep");
  expect("[obstacles.ball]\nshape = { sphere = { diameter = 0.2 } }\nposition = [0.5, 1, 0]\n",
         "2:", "its particle 8 starts 0.01 m inside of obstacle ball");
  expect("[method]\nname = \"dynamic-constraints\"\n", "10:",
         "the method dynamic-constraints does not follow obstacles, expected one of: impulse, "
         "springs, xpbd, "
         "direct, truth");
}

// The beads touch the post at equal angles, and both ends hang.
TEST_F(ObstacleScene, ARopeLiesOverAPost) {
  const std::string head = "duration = 1.0\n[method]\nname = \"direct\"\n";
  const std::string rope =
      "[connectors.rope]\nlength = 2.0\nmass = 0.1\nparticles = 201\nradius = 0.01\n"
      "from = { free = true }\nto = { free = true }\n";
  const std::string post =
      "[obstacles.post]\nshape = { cylinder = { length = 1.0, diameter = 0.1 } }\n"
      "position = [0, 2, 0]\nrotation = [1, 1, 0, 0]\n";
  for (const double turns : {0.5, 2.5}) {
    const std::string start =
        "start = { over = { obstacle = \"post\", before = 0.4, turns = " + std::to_string(turns) +
        " } }\n";
    const scenes::Scene scene = read(head + rope + start + post);
    const Connector& laid = scene.world.connectors[0];
    std::size_t touching = 0;
    for (std::size_t i = 0; i < laid.particles(); ++i) {
      const double apart =
          gap(scene.world.obstacles[0], scene.world.obstacles[0].place, laid.position[i], 0.01)
              .distance;
      EXPECT_GE(apart, -1e-9) << i;
      touching += apart < 2e-6;  // a polygon of 720 sides about the circle
      if (i == 0) continue;
      EXPECT_NEAR((laid.position[i] - laid.position[i - 1]).norm(), 0.01, 1e-8);
    }
    EXPECT_NEAR(static_cast<double>(touching), turns * 2 * 3.14159 * 0.06 / 0.01, 2) << turns;
    EXPECT_NEAR(laid.position.front().y(), 1.6, 1e-3);
    EXPECT_NEAR(laid.position.front().x(), 0.06, 1e-3);
    EXPECT_NEAR(laid.position.back().x(), -0.06, 1e-3);
    EXPECT_LT(laid.position.back().y(), 2);
  }
  const std::string often = "start = { over = { obstacle = \"post\", before = 0.4, turns = 9 } }\n";
  EXPECT_NE(said(often + post, head + rope).find("expected at most the length, 2 m"),
            std::string::npos);
  const std::string other = "start = { over = { obstacle = \"floor\", before = 0.4 } }\n";
  EXPECT_NE(said(other + "[obstacles.floor]\nshape = { plane = {} }\n", head + rope)
                .find("expected a cylinder or capsule that stands still"),
            std::string::npos);
}

// Its weight may touch the floor, the massless cord nothing.
TEST_F(ObstacleScene, AMasslessSpanMayHangOverAFloor) {
  std::string scene = kScene;
  scene.insert(scene.find("radius"), "model = \"span\"\n");
  EXPECT_EQ(said("", scene), "nothing");
  const std::string message = said("", scene + "[method]\nname = \"impulse\"\n");
  EXPECT_NE(message.find("together with"), std::string::npos) << message;
}

TEST_F(ObstacleScene, AWinchThatPushesALandedLoadIsTold) {
  const auto warnings = [&](const std::string& links, double paid_out) {
    const std::string scene =
        R"(
duration = 2.0
[obstacles.floor]
shape = { plane = {} }
[connectors.rope]
length = 1.0
mass = 0.1
particles = 6
radius = 0.01
)" + links +
        "\nfrom = { fixed = [0, 1.6, 0], winch = [{ t = 0, paid_out = 0 }, { t = 1, paid_out = " +
        std::to_string(paid_out) + R"( }] }
to = { body = "crate", point = [0, 0.1, 0] }
start = { direction = [0, -1, 0] }
[bodies.crate]
mass = 2.0
shape = { sphere = { diameter = 0.2 } }
hangs = [0, -1, 0]
contact = {}
)";
    return scenes::warnings_of(read(scene), {});
  };
  const std::vector<std::string> found = warnings("", 0.7);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("connector rope has links that push"), std::string::npos) << found[0];
  EXPECT_TRUE(warnings("links = \"pull\"", 0.7).empty());
  EXPECT_TRUE(warnings("", -0.3).empty());
}

TEST_F(ObstacleScene, TooFewBeadsAreToldWithHowManyWouldDo) {
  const std::string post =
      "[obstacles.post]\nshape = { capsule = { length = 1, diameter = 0.02 } }\n"
      "position = [0.5, 0.4, 0]\n";
  const auto warnings = [&](const std::string& scene) {
    return scenes::warnings_of(read(scene), {});
  };
  const std::vector<std::string> found = warnings(kScene + post);
  ASSERT_EQ(found.size(), 1u);
  // Two beads at radius 0.02 with their link 0.01 deep are 2 sqrt(0.01 (0.04 - 0.01)) apart.
  EXPECT_NE(found[0].find("connector rope has too few particles for obstacle post"),
            std::string::npos)
      << found[0];
  EXPECT_NE(found[0].find("30 particles would do"), std::string::npos) << found[0];
  std::string fine = kScene;
  fine.replace(fine.find("21"), 2, "30");
  EXPECT_TRUE(warnings(fine + post).empty());
}

/// A rope from (0, 1, 0) through what is at its middle.
std::string pushed(const std::string& to, const std::string& start = "") {
  return R"(duration = 1.0
[obstacles.ball]
shape = { sphere = { diameter = 0.2 } }
position = [0.4, 0.85, 0.02]
[connectors.rope]
length = 1.0
mass = 0.1
particles = 41
radius = 0.01
from = { fixed = [0, 1, 0] }
to = )" + to +
         "\nstart = { push_out = [0, 0, -1]" + start + " }\n";
}

TEST_F(ObstacleScene, AStartIsPushedOutWhereAsked) {
  for (const std::string& text : {pushed("{ fixed = [0.9, 1, 0] }"),
                                  pushed("{ free = true }", ", direction = [1, -0.4, 0]")}) {
    const World world = read(text).world;
    const Connector& rope = world.connectors[0];
    double nearest = 1;
    for (const Vec3& p : rope.position)
      nearest = std::min(nearest, (p - Vec3(0.4, 0.85, 0.02)).norm() - 0.1 - rope.radius);
    EXPECT_GE(nearest, 0);
    EXPECT_LT(nearest, 0.001) << "it lies against the ball";
    for (std::size_t k = 0; k < rope.links(); ++k)
      EXPECT_NEAR((rope.position[k + 1] - rope.position[k]).norm(), rope.rest[k],
                  1e-9 * rope.rest[k]);
    EXPECT_EQ(rope.position[0], Vec3(0, 1, 0));
  }
}

TEST_F(ObstacleScene, WhatCannotBePushedOutIsSaid) {
  EXPECT_NE(said("", pushed("{ fixed = [0.4, 0.85, 0.02] }", ", direction = [0, -1, 0]")),
            "nothing");
  expect(
      "[connectors.other]\nlength = 1\nmass = 1\nparticles = 5\nfrom = { body = \"drop\" }\n"
      "to = { fixed = [0, 2, 2.5] }\nstart = { push_out = [0, 0, -1] }\n[bodies.drop]\nmass = 1\n"
      "shape = { sphere = { diameter = 0.1 } }\nposition = [0, 2, 3]\n",
      "", "needs ends that are free, fixed, on a path or on a bone");
}

}  // namespace
}  // namespace taut::obstacle_scene_test
