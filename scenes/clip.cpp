#include "scenes/clip.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "scenes/exposure.h"

namespace taut {
namespace {

constexpr double kFade = 0.6;  // s, in which a card comes or goes

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

std::vector<std::vector<Snapshot>> record(const Scene& scene, const std::vector<ClipFrame>& frames,
                                          const std::vector<int>& wanted,
                                          const std::function<void()>& tick,
                                          const std::function<void(const Simulation&)>& watch) {
  const auto times_of = [&](const ClipFrame& frame) {
    return exposure_times(scene, frame.time, frame.rate);
  };
  // Shots may go back in time, the simulation does not. It stops for every frame of the clip:
  // methods that choose their steps would go another way without the stops.
  std::map<double, Snapshot> states;  // wanted ones
  double last = 0;
  for (const int k : wanted)
    for (const double time : times_of(frames[std::size_t(k)])) {
      states[time];
      last = std::max(last, time);
    }
  Simulation simulation = start(scene);
  for (const double time : shown_times(scene, frames)) {
    if (time > last) break;
    tick();
    simulation.advance_to(time);
    if (watch) watch(simulation);
    if (const auto found = states.find(time); found != states.end())
      found->second = simulation.state();
  }
  std::vector<std::vector<Snapshot>> result;
  for (const int k : wanted) {
    auto& shutter = result.emplace_back();
    for (const double time : times_of(frames[std::size_t(k)])) shutter.push_back(states.at(time));
  }
  return result;
}

}  // namespace taut
