#include "scenes/scene/clip.h"

#include <algorithm>
#include <cmath>

#include "scenes/scene/exposure.h"

namespace taut::scenes {
namespace {

constexpr double kFade = 0.7;  // s, in which a card comes or goes

void add_shot(const Scene& scene, const Shot& shot, std::vector<ClipFrame>& frames) {
  const int count = frame_count((shot.until - shot.from) / shot.rate, scene.fps);
  // Counted in frames of the scene, so that times of whole frames are those of every other program.
  const double start = shot.from * scene.fps, nearest = std::round(start);
  const double first = std::abs(start - nearest) < 1e-6 ? nearest : start;
  for (int k = 0; k < count; ++k) {
    const double time = (first + k * shot.rate) / scene.fps;
    frames.push_back({.shot = &shot, .time = own_time(scene, time), .rate = shot.rate});
  }
}

/// A card over a frame of a shot.
void add_card(const Scene& scene, const Card& card, ClipFrame frame, bool fades_in,
              std::vector<ClipFrame>& frames) {
  const int count = frame_count(card.duration, scene.fps);
  frame.rate = 0;
  frame.card = &card;
  for (int k = 0; k < count; ++k) {
    const double from_edge = double(fades_in ? k + 1 : count - k) / scene.fps;
    frame.card_shown = std::min(from_edge / kFade, 1.0);
    frames.push_back(frame);
  }
}

}  // namespace

std::vector<ClipFrame> clip_frames(const Scene& scene) {
  const Stage& stage = *scene.stage;
  std::vector<ClipFrame> played, frames;
  for (const Shot& shot : stage.shots) add_shot(scene, shot, played);
  add_card(scene, stage.title, played.front(), false, frames);
  frames.insert(frames.end(), played.begin(), played.end());
  add_card(scene, stage.end, played.back(), true, frames);
  return frames;
}

std::vector<double> shown_times(const Scene& scene, const std::vector<ClipFrame>& frames) {
  std::vector<double> times;
  for (const ClipFrame& frame : frames)
    for (const double time : exposure_times(scene, frame.time, frame.rate)) times.push_back(time);
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace taut::scenes
