// Shadows grow softer with the distance of what throws them, as the sun's disc has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "render/draw/shading/lighting.h"
#include "render/draw/stage_renderer.h"
#include "scenes/scene/stage.h"

namespace taut::penumbra_test {
namespace {

constexpr int kWidth = 120, kHeight = 480;
constexpr double kBox = 0.3;  // m, its side; its shadow's edge is at x = 0.15
// About 0.1 mm of the floor in a pixel.
const scenes::CameraView kCamera{Vec3(0.55, 0.45, 0), Vec3(kBox / 2, 0.1, 0), 0.08};
// The map is half a metre wide.
constexpr double kTexel = 0.5 / draw::Shading().map_size;

/// Light to 0 to 1 as the eye sees it (hand_computed_test.cpp).
double display(double radiance) {
  const double x = 0.44 * radiance;
  const double y = x * (2.51 * x + 0.06) / (x * (2.43 * x + 0.59) + 0.14);
  return y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
}

/// The light that looks so.
double radiance(double seen) {
  double low = 0, high = 4;
  for (int i = 0; i < 40; ++i) (display((low + high) / 2) < seen ? low : high) = (low + high) / 2;
  return low;
}

/// The picture of a floor under a light straight from above, and of a box that far above it (m).
picture::Picture draw(const gl::Context& context, double above) {
  scenes::Stage stage;
  stage.light = {-Vec3::UnitY(), Vec3::Ones(), Vec3::Zero(), Vec3::Zero()};
  const auto box = [](const Vec3& sides) {
    return std::make_shared<const scenes::Model>(scenes::box_model(sides, Vec3::Constant(0.6)));
  };
  stage.scenery = {box(Vec3(2, 0.2, 2))};
  stage.body_models = {box(Vec3::Constant(kBox))};
  World world;
  world.bodies.resize(1);
  draw::StageRenderer renderer(context, stage, World());
  gl::Canvas canvas(context, kWidth, kHeight, 4);
  const draw::View view{{0, 0, kWidth, kHeight}, kCamera};
  renderer.begin(canvas, {&view, 1});
  draw::FrameState instant{snapshot(world), {}, kCamera};
  instant.state.bodies[0].position = Vec3(0, 0.1 + above + kBox / 2, 0);
  renderer.draw(canvas, view.viewport, instant);
  return canvas.finish();
}

/// The same, but a sheet of the scenery throws the shadow.
picture::Picture draw_scenery(const gl::Context& context, double above) {
  constexpr double kSheet = 0.002;  // m
  scenes::Stage stage;
  stage.light = {-Vec3::UnitY(), Vec3::Ones(), Vec3::Zero(), Vec3::Zero()};
  stage.light.scenery_casts = true;
  scenes::Model sheet = scenes::box_model(Vec3(kBox, kSheet, kBox), Vec3::Constant(0.6));
  for (scenes::Vertex& v : sheet.meshes[0].vertices) v.position[1] += float(0.1 + above);
  stage.scenery = {std::make_shared<const scenes::Model>(
                       scenes::box_model(Vec3(2, 0.2, 2), Vec3::Constant(0.6))),
                   std::make_shared<const scenes::Model>(std::move(sheet))};
  draw::StageRenderer renderer(context, stage, World());
  gl::Canvas canvas(context, kWidth, kHeight, 4);
  const draw::View view{{0, 0, kWidth, kHeight}, kCamera};
  renderer.begin(canvas, {&view, 1});
  return canvas.finish();
}

/// The light at a place of the floor (m from the middle).
double light(const picture::Picture& picture, double x) {
  const Eigen::Vector4f q = draw::camera_projection(kCamera, double(kWidth) / kHeight) *
                            Eigen::Vector4f(float(x), 0.1f, 0, 1);
  const int row = int((0.5f - 0.5f * q.y() / q.w()) * kHeight);
  return radiance(*picture.at(kWidth / 2, row) / 255.0);
}

/// Where of the light that share arrives, of what arrives beside the shadow (m from the middle).
double place(const picture::Picture& picture, double share) {
  constexpr double kStep = 0.00005, kRange = 0.014;
  const double full = light(picture, kBox / 2 + kRange);
  for (double x = kBox / 2 - kRange; x < kBox / 2 + kRange; x += kStep)
    if (light(picture, x) > share * full) return x;
  return NAN;
}

/// The part of a disc of radius 1 that is seen past an edge at `d` from its middle.
double seen(double d) {
  return 0.5 + (d * std::sqrt(1 - d * d) + std::asin(d)) / std::numbers::pi;
}

TEST(Penumbra, IsAsWideAsTheSunsDiscSeenFromItsEdge) {
  const gl::Context context(gl::Backend::automatic);
  for (const double above : {0.2, 0.7, 1.7}) {
    const picture::Picture picture = draw(context, above);
    // The light meets the box's upper side first. Sixteen points stand for the disc.
    const double radius = draw::kSun * (above + kBox);
    for (const double d : {-0.5, 0.0, 0.5})
      EXPECT_NEAR(place(picture, seen(d)), kBox / 2 + d * radius, 1.5 * kTexel + 0.1 * radius)
          << above << " m, " << d;
  }
}

TEST(Penumbra, OfSceneryIsAsWide) {
  const gl::Context context(gl::Backend::automatic);
  constexpr double kRoomTexel = 2.0 / 2048;  // m; the scenery is 2 m wide
  for (const double above : {1.7, 2.5}) {
    const picture::Picture picture = draw_scenery(context, above);
    const double radius = draw::kSun * above;
    for (const double d : {-0.5, 0.0, 0.5})
      EXPECT_NEAR(place(picture, seen(d)), kBox / 2 + d * radius, 1.5 * kRoomTexel + 0.1 * radius)
          << above << " m, " << d;
  }
}

}  // namespace
}  // namespace taut::penumbra_test
