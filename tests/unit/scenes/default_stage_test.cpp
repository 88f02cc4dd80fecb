// The stage of a scene that has none.
#include "scenes/load/default_stage.h"

#include <gtest/gtest.h>

#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/stage.h"
#include "tests/support/folder.h"

namespace taut::default_stage_test {
namespace {

const std::string kRope = R"(duration = 1
fps = 30
[bodies.box]
mass = 0.5
inertia = [0.001, 0.002, 0.001]
hangs = [0, -1, 0]
[connectors.rope]
length = 2
mass = 0.3
particles = 9
from = { fixed = [5, 3, -2] }
to = { body = "box", point = [0, 0.05, 0] }
start = { direction = [0, -0.5, 1] }
[connectors.thread]
length = 1
mass = 0.002
particles = 5
from = { fixed = [5, 3, -1] }
to = { free = true }
start = { direction = [0, 0, -1] }
)";

class DefaultStage : public testing::Test {
 protected:
  scenes::Scene staged(const std::string& text) {
    scenes::Scene scene = scenes::load_scene(folder_.write("scene.toml", text), true);
    scenes::complete_stage(scene, {}, [] {});
    return scene;
  }
  Folder folder_;
};

TEST_F(DefaultStage, TheCameraSeesAllThatMovesOverTheWholeClip) {
  const scenes::Scene scene = staged(kRope);
  ASSERT_TRUE(scene.stage);
  const scenes::CameraView camera = scenes::camera_at(scene.stage->shots.at(0).camera, 0);
  Simulation simulation = scenes::start(scene);
  const scenes::Outlines outlines(scene);
  double widest = 0;
  for (int frame = 0; frame < scene.frames(); ++frame) {
    simulation.advance_to(static_cast<double>(frame) / scene.fps);
    for (const scenes::Outline& thing : outlines.of(simulation.state()))
      for (const Vec3& point : thing.points) {
        const auto at = scenes::on_picture(camera, 16.0 / 9, point);
        ASSERT_TRUE(at) << thing.name;
        widest = std::max(widest, at->cwiseAbs().maxCoeff());
      }
  }
  EXPECT_LT(widest, 0.9);
  EXPECT_GT(widest, 0.5) << "and not from far off";
}

TEST_F(DefaultStage, TheGroundIsWhereNothingGoesBelow) {
  const scenes::Scene scene = staged(kRope);
  ASSERT_EQ(scene.stage->scenery.size(), 5u) << "the cove, two pins and their rods";
  double top = 1e9, lowest = 1e9;
  for (const scenes::Vertex& vertex : scene.stage->scenery[0]->meshes[0].vertices)
    top = std::min(top, static_cast<double>(vertex.position[1]));
  Simulation simulation = scenes::start(scene);
  const scenes::Outlines outlines(scene);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    simulation.advance_to(static_cast<double>(frame) / scene.fps);
    for (const scenes::Outline& thing : outlines.of(simulation.state()))
      for (const Vec3& point : thing.points) lowest = std::min(lowest, point.y());
  }
  EXPECT_LT(top, lowest);
  EXPECT_NEAR(top, lowest, 0.1);
}

TEST_F(DefaultStage, TheBallOfAPointMassLiesOnTheGround) {
  const scenes::Scene scene = staged(R"(duration = 0.1
fps = 30
[connectors.rope]
length = 1
mass = 0.01
particles = 3
from = { fixed = [0, 1, 0] }
to = { point_mass = 1 }
)");
  double top = 1e9;
  for (const scenes::Vertex& vertex : scene.stage->scenery.at(0)->meshes[0].vertices)
    top = std::min(top, static_cast<double>(vertex.position[1]));
  EXPECT_LT(top, -0.031) << "steel of 1 kg has a radius of 31 mm";
  EXPECT_GT(top, -0.06);
}

TEST_F(DefaultStage, AFixedEndBelowWhatMovesIsHeldByAPostOnTheGround) {
  const scenes::Scene scene = staged(R"(duration = 0.1
fps = 30
[connectors.rope]
length = 1
mass = 0.01
particles = 11
from = { fixed = [0, 1, 0] }
to = { point_mass = 1 }
start = { points = [[0, 1, 0], [0, 1.3, 0], [0.05, 0.6, 0]] }
)");
  ASSERT_EQ(scene.stage->scenery.size(), 4u) << "the cove, a pin, its arm and its post";
  const auto box = [&](std::size_t i) {
    Eigen::AlignedBox3d around;
    for (const scenes::Vertex& vertex : scene.stage->scenery[i]->meshes[0].vertices)
      around.extend(Eigen::Vector3f(vertex.position.data()).cast<double>());
    return around;
  };
  const double ground = box(0).min().y();
  EXPECT_LT(ground, 0.6);
  EXPECT_NEAR(box(3).min().y(), ground, 1e-6) << "the post stands on the ground";
  EXPECT_NEAR(box(3).max().y(), 1, 1e-6) << "and is as high as the pin";
  EXPECT_TRUE(box(2).intersects(box(1))) << "the arm begins at the pin";
  EXPECT_TRUE(box(2).intersects(box(3))) << "and ends at the post";
  EXPECT_FALSE(box(3).intersects(box(1))) << "which stands behind it";
}

TEST_F(DefaultStage, LooksAreByKindAndBodiesHaveOne) {
  const scenes::Scene scene = staged(kRope);
  using Kind = scenes::ConnectorLook::Kind;
  EXPECT_EQ(scene.stage->connector_looks.at(0).kind, Kind::rope);
  EXPECT_EQ(scene.stage->connector_looks.at(1).kind, Kind::cord);
  EXPECT_TRUE(scene.stage->body_models.at(0)) << "an inertia alone is drawn as its box";
}

TEST_F(DefaultStage, TheCoveIsAroundTheCameraAndAllThatMoves) {
  const scenes::Scene scene = staged(kRope);
  Eigen::AlignedBox3d cove;
  for (const scenes::Vertex& vertex : scene.stage->scenery[0]->meshes[0].vertices)
    cove.extend(Eigen::Vector3f(vertex.position.data()).cast<double>());
  const scenes::CameraView camera = scenes::camera_at(scene.stage->shots.at(0).camera, 0);
  EXPECT_TRUE(cove.contains(camera.position));
  for (const scenes::Outline& thing : scenes::Outlines(scene).of(scenes::start(scene).state()))
    for (const Vec3& point : thing.points) EXPECT_TRUE(cove.contains(point)) << thing.name;
}

TEST_F(DefaultStage, ALevelPlaneIsTheFloor) {
  const scenes::Scene scene = staged(kRope +
                                     "[obstacles.floor]\nshape = { plane = {} }\n"
                                     "position = [0, -1, 0]\n[method]\nname = \"direct\"\n");
  double lowest = 1e9;
  for (const auto& model : scene.stage->scenery)
    if (model->name == "cove")
      for (const scenes::Vertex& vertex : model->meshes[0].vertices)
        lowest = std::min(lowest, double(vertex.position[1]));
  EXPECT_GT(lowest, -1);
  EXPECT_LT(lowest, -0.99);
}

TEST_F(DefaultStage, ACameraFollowsABody) {
  const std::string stage = "[stage]\nscenery = []\ncamera = [{ t = 0, follow = \"box\", ";
  const auto apart = [&](const std::string& keys, double time) {
    const scenes::Scene scene = staged(kRope + stage + keys + " }]\n");
    Simulation simulation = scenes::start(scene);
    simulation.advance_to(time);
    const scenes::CameraView view = scenes::camera_at(scene.stage->shots.at(0).camera, time);
    const Vec3 body = simulation.world().bodies[0].position;
    return std::pair(Vec3(view.target - body), Vec3(view.position - view.target));
  };
  for (const double time : {0.3, 0.5, 0.7}) {
    const auto [off, eye] =
        apart("target = [0, 0.2, 0], orbit = { azimuth = 0.5, distance = 3 }", time);
    EXPECT_LT((off - Vec3(0, 0.2, 0)).norm(), 0.15) << "evened out over 0.2 s";
    EXPECT_LT((eye - scenes::on_orbit({0.5, 0, 3})).norm(), 1e-9);
  }
  const scenes::Scene standing =
      staged(kRope + stage + "target = [0, 0, 0], position = [5, 2, 6] }]\n");
  const scenes::CameraView view = scenes::camera_at(standing.stage->shots.at(0).camera, 0.5);
  EXPECT_LT((view.position - Vec3(5, 2, 6)).norm(), 1e-9) << "the eye stands, and turns";
}

TEST_F(DefaultStage, ABodyStandsWhereItIsFixed) {
  const scenes::Scene scene = staged(kRope + R"([bodies.post]
shape = { box = { size = [0.1, 2, 0.1] } }
fixed = [1, 1, 0]
rotation = [0.8, 0.6, 0, 0]
)");
  Simulation simulation = scenes::start(scene);
  simulation.advance_to(0.5);
  const Body& post = simulation.world().bodies.at(1);
  EXPECT_TRUE(post.driven());
  EXPECT_EQ(post.position, Vec3(1, 1, 0));
  EXPECT_LT(post.rotation.angularDistance(Quat(0.8, 0.6, 0, 0)), 1e-7);
  EXPECT_EQ(post.mass_properties.mass, 1) << "of no account";
}

TEST_F(DefaultStage, WhatIsWrittenStays) {
  const scenes::Scene camera = staged(kRope +
                                      "[stage]\ncamera = [{ t = 0, position = [0, 0, 9], "
                                      "target = [0, 0, 0] }]\n");
  EXPECT_EQ(camera.stage->camera.at(0).position, Vec3(0, 0, 9));
  EXPECT_TRUE(camera.stage->scenery.empty());
  const scenes::Scene bare = staged(kRope + "[stage]\nscenery = []\nbackground = [0, 1, 0]\n");
  EXPECT_TRUE(bare.stage->scenery.empty());
  EXPECT_EQ(bare.stage->background, Vec3(0, 1, 0));
  EXPECT_NE(bare.stage->camera.at(0).position, scenes::CameraKey().position);
}

TEST_F(DefaultStage, WhatNoPictureHoldsIsRefused) {
  std::string far = kRope;
  far.replace(far.find("length = 2\n"), 11, "length = 1e30\n");
  try {
    staged(far);
    FAIL() << "staged";
  } catch (const scenes::BadScene& error) {
    EXPECT_NE(std::string(error.what()).find("scene.toml:1:1: what moves comes to "),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace taut::default_stage_test
