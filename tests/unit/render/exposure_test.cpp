// Which states a frame shows while its shutter is open, and how exposures differ.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "render/draw/motion_extents.h"
#include "render/draw/shading/lighting.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/clip.h"

namespace taut::exposure_test {
namespace {

const int kStates = scenes::Stage().exposures;

scenes::Scene with_shutter(double shutter, const char* method, Settings settings) {
  scenes::Scene scene;
  scene.duration = 2;
  scene.method = {method, std::move(settings)};
  scene.stage.emplace();
  scene.stage->shutter = shutter;
  return scene;
}

TEST(Exposure, AClosedShutterShowsTheFramesOwnInstant) {
  const scenes::Scene scene = with_shutter(0, "impulse", {{"step", 1.0 / 3840}});
  EXPECT_EQ(scenes::exposure_times(scene, 0.5), std::vector<double>{0.5});
}

TEST(Exposure, TimesAreTheMethodsOwnSteps) {
  const double step = 1.0 / 3840;  // 32 in half a frame
  const scenes::Scene scene = with_shutter(0.5, "impulse", {{"step", step}});
  const std::vector<double> times = scenes::exposure_times(scene, 0.5);
  ASSERT_EQ(times.size(), std::size_t(kStates));
  EXPECT_EQ(times[kStates / 2], 0.5);
  for (int i = 0; i < kStates; ++i)
    EXPECT_NEAR(times[std::size_t(i)], 0.5 + (i - kStates / 2) * step, 1e-12);
}

TEST(Exposure, EachTimeIsAnotherState) {
  const double step = 1.0 / 3840;
  for (const double rate : {0.25, 0.3, 0.5, 1 / 32.0, 0.01}) {
    const scenes::Scene scene = with_shutter(0.5, "impulse", {{"step", step}});
    const std::vector<double> times = scenes::exposure_times(scene, 0.5, rate);
    // As many as the steps are enough for, or half as many: a power of two.
    EXPECT_LE(double(times.size()), std::max(rate * kStates, 1.0) + 1e-6) << rate;
    EXPECT_GT(double(times.size()), rate * kStates / 2) << rate;
    for (std::size_t i = 0; i < times.size(); ++i) {
      EXPECT_NEAR(times[i] / step, std::round(times[i] / step), 1e-6);
      if (i > 0) {
        EXPECT_GE(times[i] - times[i - 1], 0.99 * step) << rate;
      }
    }
  }
}

TEST(Exposure, ATimeHasTheSameBitsHoweverItWasComeBy) {
  for (const double step : {1.0 / 2040, 0.0}) {
    const scenes::Scene scene = with_shutter(0.5, step > 0 ? "impulse" : "direct",
                                             step > 0 ? Settings{{"step", step}} : Settings{});
    for (int k = 0; k < 100; ++k) EXPECT_EQ(scenes::own_time(scene, k / 60.0), k / 60.0);
    for (const double time : {0.3, 0.7, 1.1})
      EXPECT_EQ(scenes::own_time(scene, time + 1e-15), scenes::own_time(scene, time - 1e-15));
  }
}

TEST(Exposure, MethodsThatChooseTheirStepsStopAnywhere) {
  const scenes::Scene scene = with_shutter(1, "direct", {{"tolerance", 1e-4}});
  const std::vector<double> times = scenes::exposure_times(scene, 0.5);
  for (std::size_t i = 1; i < times.size(); ++i)
    EXPECT_NEAR(times[i] - times[i - 1], 1.0 / 60 / kStates, 1e-12);
}

TEST(Exposure, NothingIsBeforeTheStart) {
  const scenes::Scene scene = with_shutter(0.5, "direct", {});
  const std::vector<double> times = scenes::exposure_times(scene, 0);
  EXPECT_EQ(times.front(), 0);
  EXPECT_TRUE(std::ranges::is_sorted(times));
}

class TrajectoryOf : public testing::TestWithParam<const char*> {};

TEST_P(TrajectoryOf, IsTheSameWithAnyShutter) {
  const scenes::Scene scene =
      scenes::load_scene(std::string(TAUT_SOURCE_DIR "/scenes/") + GetParam(), true);
  ASSERT_GT(scene.stage->shutter, 0);
  Simulation closed = scenes::start(scene), open = scenes::start(scene);
  for (int frame = 1; frame <= 2 * scene.fps; ++frame) {
    const double own = double(frame) / scene.fps;
    closed.advance_to(own);
    for (const double time : scenes::exposure_times(scene, own)) {
      open.advance_to(time);
      if (time == own) {
        ASSERT_EQ(state_hash(open.world()), state_hash(closed.world())) << own;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Exposure, TrajectoryOf,
                         testing::Values("nunchaku.toml", "contact/nunchaku_catch.toml",
                                         "contact/sticks_meet.toml", "contact/post.toml"));

TEST(Exposure, SlowThingsTakeFewAndFastOnesAsManyAsTheirWayAsksFor) {
  const auto counts = [](double way, int samples, int states) {
    std::vector<int> result;
    for (const draw::Exposures& e : draw::exposures(way, samples, states)) {
      EXPECT_EQ(e.way, 2 * e.count);
      result.push_back(e.count);
    }
    return result;
  };
  EXPECT_EQ(counts(4, 4, 16), (std::vector{2}));
  EXPECT_EQ(counts(4.1, 4, 16), (std::vector{2, 4}));
  EXPECT_EQ(counts(8.1, 4, 16), (std::vector{2, 4, 8}));
  EXPECT_EQ(counts(24, 4, 16), (std::vector{2, 4, 8, 16}));
  EXPECT_EQ(counts(999, 4, 16), (std::vector{2, 4, 8, 16}));
  EXPECT_EQ(counts(999, 4, 32), (std::vector{2, 4, 8, 32}));
  EXPECT_EQ(counts(999, 4, 2), (std::vector{2}));
  EXPECT_EQ(counts(5, 1, 16), (std::vector{2, 4}));
  EXPECT_EQ(counts(1.4, 1, 16), (std::vector<int>{}));
  EXPECT_EQ(counts(5, 2, 16), (std::vector{2, 4}));
  EXPECT_EQ(counts(999, 4, 1), (std::vector<int>{}));
}

TEST(Exposure, ShadowsSoftenWithTheDistanceFromWhatThrowsThem) {
  const Eigen::AlignedBox3d box(Vec3(-1, 0, -1), Vec3(1, 2, 1));
  const Vec3 down(0, -1, 0);
  const Eigen::Matrix4f straight = draw::light_map(down, box, 1024).projection;
  const double width = 1 / straight.row(0).head<3>().norm();  // m, of the map
  for (int i = 0; i < 16; ++i) {
    const Eigen::Matrix4f moved = draw::moved_light(straight, box.center(), i);
    const auto shift = [&](const Vec3& p) {
      const Eigen::Vector4f h = p.cast<float>().homogeneous();
      return width * double(((moved - straight) * h).norm());
    };
    EXPECT_NEAR(shift({0.7, 1, -0.3}), 0, 1e-6);
    EXPECT_LE(shift({0, 0, 0}), 0.0047 + 1e-5) << "the sun's radius, a metre away";
    EXPECT_NEAR(shift({0, -1, 0}), 2 * shift({0, 0, 0}), 1e-5);
  }
}

}  // namespace
}  // namespace taut::exposure_test
