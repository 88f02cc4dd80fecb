// Depth of field where the circle of confusion is known. Lenses of 50 mm at f/2, open 25 mm, on a
// picture of 24 mm and 240 pixels: at 5 m it is 2.4 m high.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "render/draw/stage_renderer.h"
#include "scenes/scene/stage.h"

namespace taut::lens_test {
namespace {

constexpr int kSize = 240;     // px
constexpr double kFar = 5;     // m, of the wall
constexpr double kRadius = 5;  // px: 25 mm (5 m - 1 m) / 1 m on the wall, at 100 pixels a metre
constexpr int kEdge = 6;       // px: what is blurred is made of pixels twice as large
constexpr double kBright = 0.5;

scenes::CameraView camera(double relative_aperture, double focus) {
  return {Vec3::Zero(), -Vec3::UnitZ(), 2 * std::atan(12.0 / 50), relative_aperture, focus};
}

/// A wall towards the camera, of one brightness; 0: nothing comes from it.
std::shared_ptr<const scenes::Model> wall(double left, double right, double away, double bright) {
  scenes::Model model;
  model.materials = {
      {"plain", {float(bright), float(bright), float(bright)}, 1, bright ? 0.0f : 1}};
  scenes::Mesh& mesh = model.meshes.emplace_back();
  for (const auto& [x, y] : {std::pair(left, -3.0), {right, -3.0}, {right, 3.0}, {left, 3.0}}) {
    scenes::Vertex& v = mesh.vertices.emplace_back();
    v.position = {float(x), float(y), float(-away)};
    v.normal = {0, 0, 1};
  }
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return std::make_shared<const scenes::Model>(model);
}

scenes::Stage stage(const Vec3& light = -Vec3::UnitZ()) {
  scenes::Stage result;
  result.light = {light.normalized(), Vec3::Ones(), Vec3::Zero(), Vec3::Zero()};
  return result;
}

/// The red channel as light, 0 to 1 (IEC 61966-2-1).
double light(const picture::Picture& picture, int x, int y) {
  const double s = *picture.at(x, y) / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

class LensTest : public testing::Test {
 protected:
  picture::Picture draw(const scenes::Stage& stage, const scenes::CameraView& seen) {
    World world;
    world.bodies.resize(stage.body_models.size());
    draw::StageRenderer renderer(context_, stage, World());
    gl::Canvas canvas(context_, kSize, kSize, 4);
    const draw::View view{{0, 0, kSize, kSize}, seen};
    renderer.begin(canvas, {&view, 1});
    if (!stage.body_models.empty()) {
      draw::FrameState instant{snapshot(world), {}, seen};
      instant.state.bodies[0].position = Vec3(0.2, 0, -kFar + 0.4);
      renderer.draw(canvas, view.viewport, instant);
    }
    return canvas.finish();
  }

  gl::Context context_{gl::Backend::automatic};
};

TEST_F(LensTest, AnEdgeOutOfFocusIsAsWideAsTheCircleOfConfusion) {
  scenes::Stage scene = stage();
  scene.scenery = {wall(-3, 0, kFar, 0), wall(0, 3, kFar, kBright)};
  const picture::Picture picture = draw(scene, camera(0.5, 1));
  const double full = light(picture, kSize - 20, kSize / 2);
  EXPECT_GT(full, 0.1);
  for (int x = kSize / 2 - 12; x < kSize / 2 + 12; ++x) {
    // The part of a disc on one side of a line.
    const double d = std::clamp((x + 0.5 - kSize / 2) / kRadius, -1.0, 1.0);
    const double share = 0.5 + (d * std::sqrt(1 - d * d) + std::asin(d)) / std::numbers::pi;
    // Two dozen points stand for the disc.
    EXPECT_NEAR(light(picture, x, kSize / 2) / full, share, 0.06) << x;
  }
}

TEST_F(LensTest, WhatIsInFocusIsToTheBitAsWithoutALens) {
  scenes::Stage scene = stage();
  scene.scenery = {wall(-3, 0, kFar, 0), wall(0, 3, kFar, kBright)};
  EXPECT_EQ(draw(scene, camera(0.5, kFar)).pixels, draw(scene, camera(0, 1)).pixels);
}

TEST_F(LensTest, WhatIsInFocusInFrontSpreadsOverNothing) {
  scenes::Stage scene = stage();
  scene.scenery = {wall(-3, 3, kFar, 0), wall(0, 3, 1, kBright)};
  const picture::Picture picture = draw(scene, camera(0.5, 1));
  for (int x = 0; x < kSize; ++x) {
    const double seen = light(picture, x, kSize / 2);
    if (x < kSize / 2 - kEdge) {
      EXPECT_LE(seen, 0.001) << x;
    } else if (x >= kSize / 2) {
      EXPECT_GT(seen, 0.1) << x;
    }
  }
}

TEST_F(LensTest, AShadowOutOfFocusIsAsDarkAsOneInFocus) {
  // The wall is even: blurred it looks the same, but for the shadow's edge.
  scenes::Stage scene = stage(Vec3(-1, 0, -1));
  scene.scenery = {wall(-9, 9, kFar, kBright)};
  const picture::Picture bare = draw(scene, camera(0, 1));
  scene.body_models = {std::make_shared<const scenes::Model>(
      scenes::box_model(Vec3::Constant(0.3), Vec3::Constant(0.6)))};
  const picture::Picture sharp = draw(scene, camera(0, 1)), soft = draw(scene, camera(0.5, 1));
  int shaded = 0, differing = 0;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      shaded += *bare.at(x, y) - *sharp.at(x, y) > 30;
      differing += std::abs(*soft.at(x, y) - *sharp.at(x, y)) > 2;
    }
  EXPECT_GT(shaded, 500);
  EXPECT_EQ(differing, 0);
}

}  // namespace
}  // namespace taut::lens_test
