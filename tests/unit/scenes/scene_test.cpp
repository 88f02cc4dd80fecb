// The meaning of scenes: where things stand at the start, what holds them, which names go together.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "tests/support/folder.h"

namespace taut::scene_test {
namespace {

class SceneTest : public testing::Test {
 protected:
  scenes::Scene read(const std::string& text, bool with_stage = false) const {
    return scenes::load_scene(folder_.write("scene.toml", "duration = 1.0\n" + text), with_stage);
  }

  Folder folder_;
};

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_LE((a - b).norm(), tolerance) << a.transpose() << " is not " << b.transpose();
}

TEST_F(SceneTest, LittleIsNeeded) {
  const scenes::Scene scene = read("");
  EXPECT_EQ(scene.title, "scene");
  EXPECT_EQ(scene.fps, 60);
  EXPECT_EQ(scene.frames(), 60);
  EXPECT_EQ(scene.method.name, "direct");
  EXPECT_EQ(scene.world.gravity, Vec3(0, -9.81, 0));
  EXPECT_FALSE(scene.stage);
}

TEST_F(SceneTest, FramesAreThoseBeforeTheEnd) {
  scenes::Scene scene;
  for (const auto& [duration, fps, frames] :
       {std::tuple(1.0, 60, 60), {0.1, 30, 3}, {0.11, 30, 4}, {12.0, 24, 288}, {1e-3, 60, 1}}) {
    scene.duration = duration;
    scene.fps = fps;
    EXPECT_EQ(scene.frames(), frames) << duration << " s at " << fps;
  }
}

TEST_F(SceneTest, StepsThatDivideAFrame) {
  EXPECT_EQ(scenes::dividing_step(1.0 / 960, 60), 1.0 / 960);
  EXPECT_EQ(scenes::dividing_step(0.00104166667, 60), 1.0 / 960);  // as people round it
  EXPECT_EQ(scenes::dividing_step(0.02, 50), 0.02);
  EXPECT_FALSE(scenes::dividing_step(0.005, 60));
  EXPECT_FALSE(scenes::dividing_step(0.02, 60));
}

// 0.1 + 0.2 is not 0.3 in doubles; beside 1e3 m it is so by more.
TEST_F(SceneTest, EndsOfARingMeetWithinTheRoundingOfTheirPlaces) {
  const auto ring = [&](const char* fixed, const char* body, const char* point) {
    return read(
        fmt::format("[bodies.a]\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nposition = {}\n"
                    "[connectors.ring]\nlength = 0.0\nmass = 0.0\nparticles = 2\n"
                    "from = {{ fixed = {} }}\nto = {{ body = \"a\", point = {} }}\n",
                    body, fixed, point));
  };
  ring("[0.3, 0.0, 0.0]", "[0.1, 0.0, 0.0]", "[0.2, 0.0, 0.0]");
  ring("[0.0, -1000.1, 0.3]", "[0.0, -1000.4, 0.1]", "[0.0, 0.3, 0.2]");
  EXPECT_THROW(ring("[0.3, 0.0, 0.0]", "[0.1, 0.0, 0.0]", "[0.2, 1e-12, 0.0]"), scenes::BadScene);
}

TEST_F(SceneTest, ABodyHangsFromWhereItsConnectorEnds) {
  const scenes::Scene scene = read(R"(
[bodies.stick]
mass = 0.1
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
hangs = [1, -1, 0]
[connectors.cord]
length = 0.1
mass = 0.01
particles = 3
from = { fixed = [0, 1, 0] }
to = { body = "stick", point = [0, 0.15, 0] }
start = { direction = [1, 0, 0] }
)");
  const Connector& cord = scene.world.connectors[0];
  expect_near(cord.position[0], {0, 1, 0});
  expect_near(cord.position[1], {0.05, 1, 0});
  const Body& stick = scene.world.bodies[0];
  expect_near(stick.point({0, 0.15, 0}), {0.1, 1, 0});
  expect_near(stick.point({0, -0.15, 0}), Vec3(0.1, 1, 0) + 0.3 * Vec3(1, -1, 0).normalized());
  EXPECT_GT(stick.mass_properties.mass, 0.1) << "the cord's last particle has joined it";
}

TEST_F(SceneTest, ChainsOfConnectorsAreLaidFromWhatHolds) {
  // Written in the order in which they cannot be laid, and the second from its end.
  const scenes::Scene scene = read(R"(
[bodies.upper]
mass = 0.1
shape = { sphere = { diameter = 0.1 } }
hangs = [0, -1, 0]
[bodies.lower]
mass = 0.1
shape = { sphere = { diameter = 0.1 } }
hangs = [0, -1, 0]
[connectors.second]
length = 0.2
mass = 0.01
particles = 3
from = { body = "lower", point = [0, 0.05, 0] }
to = { body = "upper", point = [0, -0.05, 0] }
[connectors.first]
length = 0.2
mass = 0.01
particles = 3
from = { fixed = [0, 1, 0] }
to = { body = "upper", point = [0, 0.05, 0] }
)");
  expect_near(scene.world.bodies[0].frame().position, {0, 0.75, 0});
  expect_near(scene.world.bodies[1].frame().position, {0, 0.45, 0});
  expect_near(scene.world.connectors[0].position[0], {0, 0.5, 0});
}

TEST_F(SceneTest, ABodyOnAHandsPathIsHeldAtItsGrip) {
  folder_.write("artist.glb", read_file(TAUT_SOURCE_DIR "/assets/martial_artist.glb"));
  const scenes::Scene scene = read(R"(
characters.player = { mesh = "artist.glb", right_hand = "hand" }
[paths.hand]
keys = [{ t = 0, position = [0, 1, 0], axis = [1, 0, 0] }, { t = 1, position = [0, 2, 0] }]
[bodies.stick]
mass = 0.1
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
driven_by = { character = "player", hand = "right" }
grip = [0, -0.1, 0]
)");
  const Body& stick = scene.world.bodies[0];
  expect_near(stick.point({0, -0.1, 0}), {0, 1, 0});
  expect_near(stick.point({0, 0.15, 0}), {0.25, 1, 0});
}

TEST_F(SceneTest, PathsTurnTheShortestWayAndRestWhereTheyHold) {
  const scenes::Scene scene = read(R"(
[paths.p]
keys = [
  { t = 0.0, position = [0, 0, 0], axis = [0, 1, 0] },
  { t = 0.2, position = [1, 0, 0], axis = [1, 0, 0], hold = 0.3 },
  { t = 1.0, position = [0, 0, 0] },
]
[bodies.b]
mass = 1.0
shape = { sphere = { diameter = 1 } }
driven_by = { path = "p" }
)");
  const Path& path = *scene.world.bodies[0].path;
  expect_near(path.at(0).rotation * Vec3::UnitX(), Vec3::UnitX());
  expect_near(path.at(0.2).rotation * Vec3::UnitY(), Vec3::UnitX());
  expect_near(path.at(0.2).rotation * Vec3::UnitZ(), Vec3::UnitZ());
  for (const double t : {0.2, 0.3, 0.4999}) {
    expect_near(path.at(t).position, {1, 0, 0});
    expect_near(path.at(t).velocity, Vec3::Zero());
  }
  EXPECT_GT(path.at(0.7).velocity.norm(), 0.1);
}

TEST_F(SceneTest, PathsComeFromCsvFilesToo) {
  folder_.write("hand.csv", "t,x,y,z,qw,qx,qy,qz\n0, 0,1,0, 1,0,0,0\r\n1.5, 3,1,0, 0,0,2,0\n");
  const scenes::Scene scene = read(R"(
[paths.p]
file = "hand.csv"
[bodies.b]
mass = 1.0
shape = { sphere = { diameter = 1 } }
driven_by = { path = "p" }
)");
  const auto& keys = scene.world.bodies[0].path->keys();
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[1].time, 1.5);
  expect_near(keys[1].position, {3, 1, 0});
  expect_near(keys[1].rotation * Vec3::UnitX(), -Vec3::UnitX());
}

TEST_F(SceneTest, ALineOfPointsKeepsEveryLinksLength) {
  // Corners that are not a whole number of links apart; the first goes back on itself.
  const scenes::Scene scene = read(R"(
[connectors.rope]
length = 1.0
mass = 0.1
particles = 21
from = { fixed = [0, 1, 0] }
to = { point_mass = 0.2 }
start = { points = [[0, 1, 0], [0.31, 1, 0], [0.1, 1, 0], [0.1, 1.77, 0], [3, 3, 3]] }
)");
  const Connector& rope = scene.world.connectors[0];
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR((rope.position[i + 1] - rope.position[i]).norm(), 0.05, 1e-12) << i;
  }
  EXPECT_DOUBLE_EQ(rope.particle_mass[20], 0.1 / 21 + 0.2);
  EXPECT_EQ(rope.holds.size(), 1u);
}

TEST_F(SceneTest, EndsWithPlacesHangBetweenThem) {
  const scenes::Scene scene = read(R"(
[connectors.rope]
length = 1.0
mass = 0.1
particles = 11
from = { fixed = [0, 1, 0] }
to = { fixed = [0.6, 1, 0] }
)");
  const auto& position = scene.world.connectors[0].position;
  expect_near(position.back(), {0.6, 1, 0});
  EXPECT_NEAR(position[5].x(), 0.3, 1e-9);
  EXPECT_LT(position[5].y(), 0.7);
}

TEST_F(SceneTest, JointsOfNoLengthAndSpansWithoutMass) {
  const scenes::Scene scene = read(R"(
[method]
name = "impulse"
[bodies.b]
mass = 1.0
inertia = [1.0, 1.2, 0.9, 0.1, 0, 0]
centre = [0.1, 0, 0]
position = [0, 1, 0]
rotation = [0, 0, 1, 0]
[connectors.joint]
length = 0
mass = 0
particles = 2
from = { fixed = [0, 1, 0] }
to = { body = "b" }
[connectors.cord]
length = 0.5
mass = 0
particles = 5
model = "span"
restitution = 0.25
from = { fixed = [0, 1, 0] }
to = { body = "b" }
)");
  const Body& body = scene.world.bodies[0];
  expect_near(body.frame().position, {0, 1, 0});
  expect_near(body.position, {-0.1, 1, 0});
  EXPECT_EQ(body.mass_properties.inertia(0, 1), 0.1);
  EXPECT_EQ(body.mass_properties.inertia(1, 0), 0.1);
  EXPECT_EQ(scene.world.connectors[0].position[0], scene.world.connectors[0].position[1]);
  EXPECT_EQ(scene.world.connectors[1].model, ConnectorModel::span);
  EXPECT_EQ(scene.world.connectors[1].restitution, 0.25);
}

TEST_F(SceneTest, PinsSayWhatHoldsWhatWhen) {
  const scenes::Scene scene = read(R"(
[bodies.b]
mass = 1.0
shape = { sphere = { diameter = 1 } }
position = [0, 0, 0]
[connectors.rope]
length = 1.0
mass = 0.1
particles = 11
from = { fixed = [0, 1, 0] }
to = { free = true }
[[pins]]
connector = "rope"
at = 0.25
from = 0.1
body = "b"
point = [0, 0.5, 0]
[[pins]]
connector = "rope"
at = 0.5
from = 0.2
until = 0.3
point = [0, 0.6, 0]
)");
  ASSERT_EQ(scene.timeline.pins.size(), 2u);
  EXPECT_EQ(scene.timeline.pins[0].to->kind, Attachment::Kind::body);
  EXPECT_EQ(scene.timeline.pins[0].to->point, Vec3(0, 0.5, 0));
  EXPECT_TRUE(std::isinf(scene.timeline.pins[0].until));
  EXPECT_EQ(scene.timeline.pins[1].to->kind, Attachment::Kind::fixed);
  EXPECT_EQ(scene.timeline.pins[1].to->point, Vec3(0, 0.6, 0));
  EXPECT_EQ(scene.timeline.pins[1].until, 0.3);
}

TEST_F(SceneTest, AStageShowsShapesWhereNoMeshIsNamed) {
  const scenes::Scene scene = read(R"(
[bodies.b]
mass = 1.0
shape = { box = { size = [0.1, 0.2, 0.3] } }
color = [1, 0, 0]
position = [0, 0, 0]
[bodies.c]
mass = 1.0
inertia = [1, 1, 1]
position = [0, 0, 0]
[stage]
light = { direction = [0, -2, 0] }
)",
                                   true);
  ASSERT_TRUE(scene.stage);
  const auto& models = scene.stage->body_models;
  ASSERT_EQ(models.size(), 2u);
  ASSERT_TRUE(models[0]);
  EXPECT_EQ(models[0]->materials.at(0).base_color, (std::array<float, 3>{1, 0, 0}));
  EXPECT_FALSE(models[1]) << "an inertia has no shape";
  expect_near(scene.stage->light.direction, {0, -1, 0});
  EXPECT_EQ(scene.stage->camera.size(), 1u);
}

// One edit each, as a person would make it.
const std::filesystem::path kNunchaku = TAUT_SOURCE_DIR "/scenes/nunchaku.toml";

TEST(NunchakuScene, OneKeyMovesHandArmStickAndCord) {
  const scenes::Scene before = scenes::load_scene(kNunchaku, true);
  std::string text = read_file(kNunchaku);
  // The first number of the first key's position, with another one in its place.
  const std::size_t list = text.find('[', text.find("\nkeys = "));
  const std::size_t x = text.find("position = [", list) + 12;
  text.replace(x, text.find(',', x) - x, "-0.2");
  const std::string keys = text.substr(list, text.find("\n]", list) + 2 - list);
  const scenes::Scene after =
      scenes::load_scene(kNunchaku, true, {{"paths.right_hand.keys", keys}});

  const Vec3 shift =
      after.world.bodies[0].path->at(0).position - before.world.bodies[0].path->at(0).position;
  EXPECT_GT(shift.norm(), 0.01);
  expect_near(after.world.bodies[0].position - before.world.bodies[0].position, shift, 1e-9);
  expect_near(after.world.connectors[0].position[0] - before.world.connectors[0].position[0], shift,
              1e-9);
  expect_near(after.world.bodies[1].position - before.world.bodies[1].position, shift, 1e-9);
  const scenes::Model& model = *after.stage->characters[0];
  const auto bone = [&](const scenes::Scene& scene, const char* name) {
    return scene.performances[0]->bones_at(0)[static_cast<std::size_t>(model.bone(name))].position;
  };
  expect_near(bone(after, "RightHand") - bone(before, "RightHand"), shift, 0.02);
}

TEST(NunchakuScene, AnotherMeshReplacesTheStick) {
  const scenes::Scene before = scenes::load_scene(kNunchaku, true);
  const scenes::Scene after =
      scenes::load_scene(kNunchaku, true, {{"bodies.held.mesh", "\"assets/stick_lacquer.glb\""}});
  EXPECT_EQ(before.stage->body_models[0], before.stage->body_models[1]) << "one file, one model";
  EXPECT_NE(after.stage->body_models[0]->name, after.stage->body_models[1]->name);
}

TEST_F(SceneTest, RepeatsAConnectorInPlaceAndTime) {
  const scenes::Scene scene = read(R"(
[paths.top]
keys = [{ t = 0, position = [0, 2, 0], ease = true }, { t = 0.1, position = [0.1, 2, 0], ease = true }]

[connectors.cord]
length = 1
mass = 0.1
particles = 3
from = { path = "top" }
to = { point_mass = 0.2 }
repeat = [{ count = 3, by = [0.5, 0, 0], delay = 0.01 }, { count = 2, by = [0, 0, 1] }]

[connectors.other]
length = 1
mass = 0.1
particles = 2
from = { fixed = [9, 0, 0] }
to = { free = true }

[stage]
)",
                                   true);
  const auto& all = scene.world.connectors;
  ASSERT_EQ(all.size(), 7u);
  EXPECT_EQ(all[1].name, "other");  // what the file names comes first
  EXPECT_EQ(all[2].name, "cord#2");
  EXPECT_EQ(scene.stage->connector_looks.size(), all.size());
  const std::size_t far = 6;  // the third of the second row
  expect_near(all[far].position[2], {1, 1, 1});
  EXPECT_EQ(all[far].particle_mass, all[0].particle_mass);
  for (const double time : {0.0, 0.06, 0.3}) {  // 20 ms later
    const PointMotion copy = hold_motion(scene.world, all[far].holds[0].to, time + 0.02);
    const PointMotion first = hold_motion(scene.world, all[0].holds[0].to, time);
    expect_near(copy.position, first.position + Vec3(1, 0, 1));
    expect_near(copy.velocity, first.velocity, 1e-11);
  }
}

/// The scenes of the comparison with engines: what is fixed by it.
TEST(BenchScenes, AreWhatEnginesAreComparedOn) {
  const auto read = [](const std::string& name) {
    return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/bench_" + name + ".toml", false);
  };
  const auto expect_swing = [](const World& world, std::size_t particles, double handle) {
    const Connector& rope = world.connectors.at(0);
    ASSERT_EQ(rope.particles(), particles);
    const double share = 0.05 / static_cast<double>(particles);
    for (std::size_t i = 0; i + 1 < particles; ++i) {
      EXPECT_NEAR(rope.particle_mass[i], share, 1e-15);
    }
    EXPECT_NEAR(rope.particle_mass.back(), handle + share, 1e-15);
    EXPECT_EQ(rope.holds.size(), 1u);
    expect_near(rope.position.back() - rope.position.front(), {0.2, 0, 0});
  };
  expect_swing(read("swing").world, 21, 0.2);
  expect_swing(read("heavy").world, 51, 5.0);

  const scenes::Scene scene = read("stick");
  const Connector& cord = scene.world.connectors.at(0);
  EXPECT_EQ(cord.particles(), 11u);
  expect_near(cord.position.back() - cord.position.front(), {0, -0.1, 0});
  const Body& stick = scene.world.bodies.at(0);
  expect_near(stick.frame().position, {0, 1 - 0.1 - 0.15, 0});
  EXPECT_EQ(stick.bare.mass, 0.25);
  // One turn and an eighth in the first second, at 1.5 turns a second.
  const PointMotion hand = hold_motion(scene.world, cord.holds.at(0).to, 1);
  const double r = 0.15, eighth = std::sqrt(0.5);
  expect_near(hand.position, {r * eighth, 1.15 - r * eighth, 0});
  EXPECT_NEAR(hand.velocity.norm(), 2 * std::numbers::pi * 1.5 * r, 1e-12);
}

TEST_F(SceneTest, IsMadeOfTheFilesThatItNames) {
  folder_.write("hand.csv", "t,x,y,z\n0,0,1,0\n");
  folder_.write("ball.glb", "");
  folder_.write("base.toml", "duration = 1.0\n");
  const auto file = folder_.write("scene.toml", R"(extends = "base.toml"
paths.hand = { file = "hand.csv" }
bodies.ball = { mass = 1.0, mesh = "ball.glb", inertia = [1, 1, 1] }
bodies.none = { mass = 1.0, mesh = "none.glb" }
[stage]
scenery = ["ball.glb"]
)");
  std::vector<std::string> names;
  for (const auto& path : scenes::scene_files(file)) names.push_back(path.filename().string());
  EXPECT_EQ(names, (std::vector<std::string>{"scene.toml", "base.toml", "hand.csv", "ball.glb",
                                             "ball.glb"}));
  EXPECT_EQ(scenes::scene_files(folder_.path() / "no.toml").size(), 1u);
}

}  // namespace
}  // namespace taut::scene_test
