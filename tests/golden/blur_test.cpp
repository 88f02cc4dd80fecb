// Motion blur: pictures of moving boxes whose light can be computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/draw/stage_renderer.h"
#include "scenes/scene/stage.h"

namespace taut::blur_test {
namespace {

constexpr int kWidth = 400, kHeight = 100, kStates = 32;
constexpr double kDistance = 4, kFieldOfView = 0.2;
const scenes::CameraView kCamera{Vec3(0, 0, kDistance), Vec3::Zero(), kFieldOfView};
/// Pixels to a metre at the boxes' front sides.
const double kMetre = kHeight / (2 * (kDistance - 0.01) * std::tan(kFieldOfView / 2));

/// sRGB (IEC 61966-2-1) to linear light.
double light(int value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

class Blur : public testing::Test {
 protected:
  static scenes::Stage boxes() {
    scenes::Stage stage;
    stage.background.setZero();
    stage.light = {Vec3(0, 0, -1), Vec3::Zero(), Vec3::Ones(), Vec3::Ones()};
    const Vec3 white = Vec3::Ones();
    // The first box flies through the picture, the second stands at its left.
    for (int i = 0; i < 2; ++i)
      stage.body_models.push_back(
          std::make_shared<const scenes::Model>(scenes::box_model(Vec3(0.2, 0.2, 0.02), white)));
    return stage;
  }
  Blur() { world_.bodies.resize(2); }

  /// The first box at `x` (m).
  draw::FrameState instant(double x, double time = 0) const {
    draw::FrameState result{snapshot(world_), {}, kCamera};
    result.state.time = time;
    result.state.bodies[0].position = Vec3(x, 0, 0);
    result.state.bodies[1].position = Vec3(-0.6, 0, 0);
    return result;
  }

  /// The first box passes `at` (m) in the middle of the shutter, and comes `pixels` meanwhile.
  std::vector<draw::FrameState> shutter(double at, double pixels) const {
    std::vector<draw::FrameState> instants;
    for (int i = 0; i < kStates; ++i)
      instants.push_back(
          instant(at + (i - kStates / 2) * pixels / kMetre / (kStates - 1), i / 3840.0));
    return instants;
  }

  picture::Picture expose(std::span<const draw::FrameState> instants, int* count = nullptr) {
    return expose(canvas_, instants, count);
  }
  picture::Picture expose(gl::Canvas& canvas, std::span<const draw::FrameState> instants,
                          int* count = nullptr) {
    const draw::View view{{0, 0, kWidth, kHeight}, kCamera};
    renderer_.begin(canvas, {&view, 1});
    const int exposures = renderer_.expose(canvas, view.viewport, instants);
    if (count) *count = exposures;
    return canvas.finish();
  }

  const scenes::Stage stage_ = boxes();
  World world_;
  gl::Context context_{gl::Backend::automatic};
  draw::StageRenderer renderer_{context_, stage_, World()};
  gl::Canvas canvas_{context_, kWidth, kHeight, 4};
};

TEST_F(Blur, APixelHasTheLightOfTheTimeForWhichItIsCovered) {
  const double kTravel = 120, kSide = 0.2 * kMetre, kAt = 0.2;
  const std::vector<draw::FrameState> instants = shutter(kAt, kTravel);
  int count = 0;
  const picture::Picture picture = expose(instants, &count);
  EXPECT_EQ(count, kStates);
  const picture::Picture sharp = expose({&instants[kStates / 2], 1});
  const double full = light(*sharp.at(kWidth / 2 + int(kAt * kMetre), kHeight / 2));
  EXPECT_GT(full, 0.1);
  int partly = 0;
  for (int x = kWidth / 2 - 50; x < kWidth; ++x) {
    double covered = 0;
    for (const draw::FrameState& i : instants) {
      const double left = kWidth / 2 + i.state.bodies[0].position.x() * kMetre - kSide / 2;
      covered += std::clamp(std::min(x + 1.0, left + kSide) - std::max(double(x), left), 0.0, 1.0);
    }
    covered /= kStates;
    partly += covered > 0.01 && covered < 0.99;
    // Each state has one sample of the pixel.
    EXPECT_NEAR(light(*picture.at(x, kHeight / 2)) / full, covered, 1.5 / kStates) << x;
  }
  EXPECT_NEAR(partly, kTravel + kSide, 3) << "the box is nowhere for the whole time";
}

TEST_F(Blur, MoreWayTakesMoreExposuresUpToTheStates) {
  int slowest = 0, slow = 0, fast = 0, still = 0;
  expose(shutter(0, 2.5), &slowest);
  expose(shutter(0, 5), &slow);
  expose(shutter(0, 10), &fast);
  const picture::Picture picture = expose(shutter(0, 0), &still);
  EXPECT_EQ(slowest, 2);
  EXPECT_EQ(slow, 4);
  EXPECT_EQ(fast, 8);
  EXPECT_EQ(still, 1);
  const draw::FrameState alone = instant(0);
  EXPECT_EQ(picture.pixels, expose({&alone, 1}).pixels);
}

TEST_F(Blur, ExposuresAreAsNearAsTheStageAsksForAndNoMoreThanThatTakes) {
  const double most = scenes::Stage().exposures_apart;
  for (double way = 2.1; way < 45; way += 1) {
    int count = 0;
    expose(shutter(0, way), &count);
    const double apart = way / (kStates - 1) * kStates / count;
    EXPECT_LE(apart, most + 1e-3) << way;
    EXPECT_TRUE(count == 2 || 2 * apart > most) << way;
  }
}

TEST_F(Blur, UnevenStatesCountByTheLongestTimeBetweenThem) {
  std::vector<draw::FrameState> instants;
  for (int i = 0; i < kStates; ++i) {
    const int step = i + (i >= 5);  // one is left out
    instants.push_back(instant(0.1 + step * 0.235 / kMetre, step / 3840.0));
  }
  int count = 0;
  expose(instants, &count);
  EXPECT_EQ(count, 8);  // with 4, neighbours would be nine steps of 0.235 px apart
}

TEST_F(Blur, TheFastestThingsLeaveNoStripes) {
  const std::vector<draw::FrameState> instants = shutter(0.1, 180);
  int count = 0;
  const picture::Picture picture = expose(instants, &count);
  EXPECT_EQ(count, kStates);
  const picture::Picture sharp = expose({&instants[kStates / 2], 1});
  const double full = light(*sharp.at(kWidth / 2 + int(0.1 * kMetre), kHeight / 2));
  // Behind it light falls evenly to its rear end, a 32nd at a time.
  const double front = kWidth / 2 + (instants.back().state.bodies[0].position.x() - 0.1) * kMetre;
  for (int x = int(front) + 8; x < kWidth - 8; ++x) {
    const double here = light(*picture.at(x, kHeight / 2)) / full;
    const double next = light(*picture.at(x + 6, kHeight / 2)) / full;
    EXPECT_LT(std::abs(next - here), 2.5 / kStates) << x;
  }
}

TEST_F(Blur, WhatStandsIsDrawnAsWithoutAShutter) {
  const std::vector<draw::FrameState> instants = shutter(0.1, 60);
  const picture::Picture blurred = expose(instants), sharp = expose({&instants[kStates / 2], 1});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth / 2 - 60; ++x)
      for (int k = 0; k < 3; ++k)
        ASSERT_EQ(blurred.at(x, y)[k], sharp.at(x, y)[k]) << x << ", " << y;
}

TEST_F(Blur, AFrameDependsOnItsShutterAlone) {
  for (const double way : {60.0, 0.0, 8.0, 60.0, 20.0, 60.0}) {
    const std::vector<draw::FrameState> instants = shutter(way / 200, way);
    gl::Canvas alone(context_, kWidth, kHeight, 4);
    EXPECT_EQ(expose(instants).pixels, expose(alone, instants).pixels) << way;
  }
}

}  // namespace
}  // namespace taut::blur_test
