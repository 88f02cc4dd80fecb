// Savings of work show in no picture: every clip of the scenes here, drawn with and without.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "render/film/film.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/clip.h"
#include "tests/support/folder.h"

namespace taut::savings_test {
namespace {

namespace fs = std::filesystem;
const fs::path kScenes = fs::path(TAUT_SOURCE_DIR) / "scenes";
constexpr int kSamples = 4, kMap = draw::Shading().map_size / 3;
constexpr int kSeldom = 10000;  // pixels, of which one may differ
constexpr double kTorn = 8;     // of 255, of a mean over pixels

/// How many pixels differ by more than one of 255.
int differing(const picture::Picture& a, const picture::Picture& b) {
  int count = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      count += std::abs(a.at(x, y)[0] - b.at(x, y)[0]) > 1 ||
               std::abs(a.at(x, y)[1] - b.at(x, y)[1]) > 1 ||
               std::abs(a.at(x, y)[2] - b.at(x, y)[2]) > 1;
  return count;
}

/// The largest difference of a channel's mean over 8 x 8 pixels: what is torn differs here, too,
/// and what is smeared by more exposures hardly.
double smooth_difference(const picture::Picture& a, const picture::Picture& b) {
  constexpr int kSide = 8;
  double most = 0;
  for (int top = 0; top + kSide <= a.height; top += kSide / 2)
    for (int left = 0; left + kSide <= a.width; left += kSide / 2)
      for (int k = 0; k < 3; ++k) {
        int sum = 0;
        for (int y = top; y < top + kSide; ++y)
          for (int x = left; x < left + kSide; ++x) sum += a.at(x, y)[k] - b.at(x, y)[k];
        most = std::max(most, std::abs(sum) / double(kSide * kSide));
      }
  return most;
}

/// A clip at a size of one's choice, in which as much moves and is as much out of focus as in its
/// own, at `apart` times the distance from one exposure to the next.
class Clip {
 public:
  Clip(const std::string& name, int height, double apart)
      : scene_(scenes::load_scene(kScenes / (name + ".toml"), true)),
        shrink_(double(height) / scene_.height) {
    scene_.stage->exposures_apart *= apart * shrink_;
    for (scenes::Shot& shot : scene_.stage->shots)
      for (scenes::CameraKey& key : shot.camera) key.relative_aperture /= shrink_;
    scene_.width = height * scene_.width / scene_.height;
    scene_.height = height;
    frames_ = scenes::clip_frames(scene_);
  }

  int frames() const { return int(frames_.size()); }

  /// Calls `compare(frame, its states)` for every `step`-th frame.
  template <typename Compare>
  void each(int step, Compare compare) const {
    std::vector<int> wanted;
    for (int k = 0; k < std::ssize(frames_); k += step) wanted.push_back(k);
    const auto states = scenes::record(scene_, frames_, wanted, [] {});
    for (std::size_t i = 0; i < wanted.size(); ++i)
      compare(frames_[std::size_t(wanted[i])], states[i]);
  }

  film::Film film(const gl::Context& context, draw::Savings savings) const {
    return {context,       scene_,   scene_.width,
            scene_.height, kSamples, {.map_size = kMap, .savings = savings, .still = shrink_}};
  }
  int number(const scenes::ClipFrame& frame) const { return int(&frame - frames_.data()); }

 private:
  scenes::Scene scene_;
  double shrink_;
  std::vector<scenes::ClipFrame> frames_;
};

/// `most` frames of a clip, or all, have the same pixels with all savings as with all drawn whole,
/// within one of 255. Two sums round otherwise: the weights of the shadow's filter, which are
/// looked up all over the scenery instead of where a shadow can reach; and the mean of the pictures
/// that more exposures than samples make, taken everywhere instead of where something moves. Where
/// two faces of the scenery have one depth, the last is in front: seldom a pixel.
void expect_nothing_shows(const std::string& name, int height, int most, double apart) {
  const Clip clip(name, height, apart);
  const int step = std::max(clip.frames() / most, 1);
  const gl::Context context(gl::Backend::automatic);
  film::Film saving = clip.film(context, draw::Savings::all),
             whole = clip.film(context, draw::Savings::exposures);
  clip.each(
      step, [&](const scenes::ClipFrame& frame, const scenes::ClipSimulation::Shutter& states) {
        const std::vector<draw::FrameState> shutter = saving.shutter(frame, states);
        const film::Film::Frame a = saving.draw(frame, shutter), b = whole.draw(frame, shutter);
        ASSERT_EQ(a.exposures, b.exposures);
        EXPECT_LE(differing(a.picture, b.picture), 1 + a.picture.width * a.picture.height / kSeldom)
            << name << ", frame " << clip.number(frame) << ", " << a.exposures << " exposures";
      });
}

/// The scenes here with a stage.
std::vector<std::string> clips() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    const std::string text = read_file(entry.path());
    if (text.find("\n[stage") != text.npos || text.find("\nextends") != text.npos)
      names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

class SavingsShow : public testing::TestWithParam<std::string> {};

TEST_P(SavingsShow, InNoneOfFourFrames) {
  if (GetParam() == "bead_curtain") GTEST_SKIP() << "a thousand cords: a long test";
  expect_nothing_shows(GetParam(), 72, 4, 2);
}

INSTANTIATE_TEST_SUITE_P(All, SavingsShow, testing::ValuesIn(clips()),
                         [](const auto& scene) { return scene.param; });

class LongSavingsShow : public testing::TestWithParam<std::string> {};

TEST_P(LongSavingsShow, InNoFrameOfFullSize) {
  const int height = scenes::load_scene(kScenes / (GetParam() + ".toml"), true).height;
  expect_nothing_shows(GetParam(), height, std::numeric_limits<int>::max(), 1);
}

INSTANTIATE_TEST_SUITE_P(Long, LongSavingsShow, testing::ValuesIn(clips()),
                         [](const auto& scene) { return scene.param; });

// Pictures in which everything takes as many exposures as the fastest thing look the same but for
// how slow things are smeared.
TEST(LongSlowThings, LookAsWithMoreExposures) {
  const Clip clip("nunchaku", 90, 2);
  const gl::Context context(gl::Backend::automatic);
  film::Film saving = clip.film(context, draw::Savings::all),
             whole = clip.film(context, draw::Savings::none);
  clip.each(160,
            [&](const scenes::ClipFrame& frame, const scenes::ClipSimulation::Shutter& states) {
              const std::vector<draw::FrameState> shutter = saving.shutter(frame, states);
              EXPECT_LT(smooth_difference(saving.draw(frame, shutter).picture,
                                          whole.draw(frame, shutter).picture),
                        kTorn)
                  << clip.number(frame);
            });
}

// A piece of the floor without the shadow that falls there, as a scissor cuts it out.
TEST(LongPlantedTear, IsSeen) {
  const Clip clip("nunchaku", 180, 2);
  const gl::Context context(gl::Backend::automatic);
  film::Film film = clip.film(context, draw::Savings::all);
  clip.each(740, [&](const scenes::ClipFrame& frame,
                     const scenes::ClipSimulation::Shutter& states) {
    if (clip.number(frame) != 740) return;
    std::vector<draw::FrameState> shutter = film.shutter(frame, states);
    const picture::Picture whole = film.draw(frame, shutter).picture;
    for (draw::FrameState& instant : shutter) {  // everybody has left
      for (auto& bones : instant.bones)
        for (Pose& bone : bones) bone.position.y() += 50;
      for (Pose& body : instant.state.bodies) body.position.y() += 50;
      for (auto& particles : instant.state.connectors)
        for (Vec3& p : particles) p.y() += 50;
    }
    const picture::Picture empty = film.draw(frame, shutter).picture;
    // The first shadow from the left, above the captions.
    picture::Picture torn = whole;
    constexpr int kWide = 14, kHigh = 6;
    int left = 0, top = 0;
    const auto shaded = [&](int x, int y) { return empty.at(x, y)[0] - whole.at(x, y)[0] > 30; };
    for (left = 0; left + kWide < whole.width; ++left) {
      for (top = 130; top + kHigh < 155 && !shaded(left + 3, top + 3); ++top) continue;
      if (top + kHigh < 155) break;
    }
    ASSERT_LT(left + kWide, whole.width);
    for (int y = top; y < top + kHigh; ++y)
      std::copy_n(empty.at(left, y), 4 * kWide, torn.at(left, y));
    EXPECT_GT(differing(torn, whole), whole.width * whole.height / kSeldom);
    EXPECT_GT(smooth_difference(torn, whole), kTorn);
  });
}

}  // namespace
}  // namespace taut::savings_test
