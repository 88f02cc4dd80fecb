// Faults that shadow maps and 8-bit pictures are known for, looked for where the right light is
// known.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>

#include "render/draw/shading/lighting.h"
#include "render/draw/stage_renderer.h"
#include "scenes/scene/stage.h"

namespace taut::light_test {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr double kBox = 0.3, kFloor = 6, kTop = 0.1;  // m: sides, and the height of the floor's top
const scenes::CameraView kCamera{Vec3(0.6, 1.6, 2.4), Vec3(0.2, 0.2, 0), 0.5};
// With this box's extent the map is 1.5 m wide at most.
constexpr double kTexel = 1.5 / draw::Shading().map_size;

class LightTest : public testing::Test {
 protected:
  static scenes::Stage stage(const Vec3& light) {
    scenes::Stage result;
    result.background.setConstant(0.2);
    result.light = {light.normalized(), Vec3::Ones(), Vec3::Zero(), Vec3::Zero()};
    return result;
  }
  static std::shared_ptr<const scenes::Model> box(const Vec3& sides) {
    return std::make_shared<const scenes::Model>(scenes::box_model(sides, Vec3::Constant(0.6)));
  }
  /// A body at a height (m), or nothing but scenery.
  picture::Picture draw(const scenes::Stage& stage, std::optional<double> height, int samples = 4) {
    World world;
    world.bodies.resize(stage.body_models.size());
    draw::StageRenderer renderer(context_, stage, World());
    gl::Canvas canvas(context_, kWidth, kHeight, samples);
    const draw::View view{{0, 0, kWidth, kHeight}, kCamera};
    renderer.begin(canvas, {&view, 1});
    if (height) {
      draw::FrameState instant{snapshot(world), {}, kCamera};
      instant.state.bodies[0].position = Vec3(0, *height, 0);
      renderer.draw(canvas, view.viewport, instant);
    }
    return canvas.finish();
  }
  /// Where a point is on the picture, -1 to 1 both ways.
  static Eigen::Vector2f place(const Vec3& point) {
    const Eigen::Vector4f q = draw::camera_projection(kCamera, double(kWidth) / kHeight) *
                              point.cast<float>().homogeneous();
    return q.head<2>() / q.w();
  }
  static bool is_seen(const Vec3& point) { return place(point).cwiseAbs().maxCoeff() < 0.99f; }
  static int value(const picture::Picture& picture, const Vec3& point) {
    const Eigen::Vector2f at = place(point);
    return *picture.at(int((0.5f + 0.5f * at.x()) * kWidth), int((0.5f - 0.5f * at.y()) * kHeight));
  }

  gl::Context context_{gl::Backend::automatic};
};

TEST_F(LightTest, SidesInTheLightHaveNoAcne) {
  // A convex body does not shade itself: it looks as scenery does, which nothing shades. With more
  // samples than one scenery has smoother edges.
  for (const double steep : {0.05, 0.2, 0.5, 1.0, 3.0, 10.0}) {
    scenes::Stage shaded = stage(Vec3(-0.4, -steep, -0.7)), plain = shaded;
    shaded.body_models.push_back(box(Vec3::Constant(kBox)));
    plain.scenery.push_back(box(Vec3::Constant(kBox)));
    const picture::Picture picture = draw(shaded, 0.0, 1), right = draw(plain, {}, 1);
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) wrong += std::abs(*picture.at(x, y) - *right.at(x, y)) > 2;
    EXPECT_EQ(wrong, 0) << steep;
  }
}

TEST_F(LightTest, ShadowsBeginAtTheFootOfWhatThrowsThemAndEndWhereTheyShould) {
  scenes::Stage scene = stage(Vec3(1, -1, 0));
  scene.scenery.push_back(box(Vec3(kFloor, 2 * kTop, kFloor)));
  const picture::Picture bare = draw(scene, {});
  scene.body_models.push_back(box(Vec3::Constant(kBox)));
  const picture::Picture picture = draw(scene, kTop + kBox / 2);
  // Light falls at 45 degrees: the shadow is as long as the box is high. Beside the true edge it
  // may stray by the filter's two texels and the offsets of one and a half each, both slanted.
  const double stray = 2 * std::sqrt(2.0) * (2 + 1.5 + 1.5) * kTexel;
  const auto lit = [&](double from_foot) {
    const Vec3 point(kBox / 2 + from_foot, kTop, 0);
    return double(value(picture, point)) / value(bare, point);
  };
  for (double d = stray; d < kBox - stray; d += 0.004) EXPECT_LT(lit(d), 0.6) << d;
  for (double d = kBox + stray; d < 2 * kBox; d += 0.004) EXPECT_GT(lit(d), 0.98) << d;
}

TEST_F(LightTest, NothingIsShadedBeyondTheMap) {
  scenes::Stage scene = stage(Vec3(1, -1, 0.2));
  scene.scenery.push_back(box(Vec3(kFloor, 2 * kTop, kFloor)));
  const picture::Picture bare = draw(scene, {});
  scene.body_models.push_back(box(Vec3::Constant(kBox)));
  const picture::Picture picture = draw(scene, kTop + kBox / 2);
  int seen = 0;
  for (double x = -2; x < 2; x += 0.01)
    for (double z = -2.5; z < 1.5; z += 0.01) {
      const bool beside = x > 2 * kBox || z > 2 * kBox;  // of the box, its shadow, what it hides
      const Vec3 point(x, kTop, z);
      if (!beside || !is_seen(point)) continue;
      ++seen;
      EXPECT_EQ(value(picture, point), value(bare, point)) << x << ", " << z;
    }
  EXPECT_GT(seen, 10000);
}

TEST_F(LightTest, SlowGradientsHaveNoBands) {
  // A ball that fills the middle of the picture, a little brighter where the light comes from.
  scenes::Stage scene = stage(Vec3(-1, -1, -0.5));
  scene.light.color.setConstant(0.15);
  scene.light.sky.setConstant(0.5);
  scene.light.ground.setConstant(0.5);
  scene.scenery.push_back(
      std::make_shared<const scenes::Model>(scenes::sphere_model(2, Vec3::Constant(0.6))));
  const picture::Picture picture = draw(scene, {});
  constexpr int kBlock = 16;
  double low = 255, high = 0, worst = 0;
  for (int y = 80; y + kBlock <= 280; y += kBlock) {
    std::vector<double> means;
    for (int x = 220; x + kBlock <= 420; x += kBlock) {
      int sum = 0;
      for (int v = 0; v < kBlock; ++v)
        for (int u = 0; u < kBlock; ++u) sum += *picture.at(x + u, y + v);
      means.push_back(double(sum) / (kBlock * kBlock));
      low = std::min(low, means.back());
      high = std::max(high, means.back());
    }
    for (std::size_t i = 1; i + 1 < means.size(); ++i)
      worst = std::max(worst, std::abs(means[i - 1] - 2 * means[i] + means[i + 1]));
  }
  // Without dither a block's mean would go in steps of whole values here and there.
  EXPECT_GT(high - low, 4);
  EXPECT_LT(high - low, 60);
  EXPECT_LT(worst, 0.4);
}

}  // namespace
}  // namespace taut::light_test
