#include "scenes/scene/clip.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

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

namespace {

/// Where the points are that leave the stage's trails; not finite where there is none.
std::vector<Vec3> trail_heads(const Scene& scene, const Snapshot& state) {
  std::vector<Vec3> heads;
  for (const Trail& trail : scene.stage->trails) {
    Vec3& head = heads.emplace_back(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
    if (!trail.connector) {
      head = state.bodies.at(trail.index).to_world(trail.point);
    } else if (const auto& particles = state.connectors.at(trail.index);
               trail.particle < particles.size()) {  // or a cut has taken it away
      head = particles[trail.particle];
    }
  }
  return heads;
}

}  // namespace

// The simulation stops for every frame of the clip: methods that choose their steps would go
// another way without the stops.
ClipSimulation::ClipSimulation(const Scene& scene, const std::vector<ClipFrame>& frames,
                               const std::vector<int>& wanted, Tick tick, Watch watch)
    : scene_(scene),
      tick_(std::move(tick)),
      watch_(std::move(watch)),
      stops_(shown_times(scene, frames)),
      simulation_(start(scene)) {
  if (scene.stage)
    for (const Trail& trail : scene.stage->trails)
      longest_trail_ = std::max(longest_trail_, trail.lasts);
  order_.reserve(wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const ClipFrame& frame = frames[std::size_t(wanted[i])];
    order_.push_back({exposure_times(scene, frame.time, frame.rate).front(), i, &frame});
  }
  std::ranges::sort(order_, {}, [](const Wanted& w) { return std::tuple(w.opens, w.index); });
}

ClipSimulation::Shutter ClipSimulation::next() {
  const Wanted& wanted = order_[next_];
  const std::vector<double> times = exposure_times(scene_, wanted.frame->time, wanted.frame->rate);
  // No later frame's shutter opens sooner.
  states_.erase(states_.begin(), states_.lower_bound(times.front()));
  while (stop_ < stops_.size() && stops_[stop_] <= times.back()) {
    tick_();
    const double time = stops_[stop_++];
    simulation_.advance_to(time);
    if (watch_) watch_(simulation_);
    if (longest_trail_ > 0)
      ways_.emplace_hint(ways_.end(), time, trail_heads(scene_, simulation_.state()));
    if (time >= times.front()) states_.emplace_hint(states_.end(), time, simulation_.state());
  }
  Shutter shutter{wanted.index, {}, trails(*wanted.frame)};
  for (const double time : times) shutter.states.push_back(states_.at(time));
  ++next_;
  return shutter;
}

std::vector<TrailPoints> ClipSimulation::trails(const ClipFrame& frame) {
  std::vector<TrailPoints> all;
  if (longest_trail_ <= 0) return all;
  constexpr double kTimeRounding = 1e-9;  // s
  const double now = frame.time + kTimeRounding;
  // A later frame's shutter opens half a frame's time before it, at most.
  const double oldest = now - longest_trail_ - std::max(frame.rate, 0.0) / scene_.fps;
  ways_.erase(ways_.begin(), ways_.lower_bound(oldest));
  for (std::size_t i = 0; i < scene_.stage->trails.size(); ++i) {
    const Trail& trail = scene_.stage->trails[i];
    const double from =
        std::max({frame.time - trail.lasts, frame.shot->from, trail.from}) - kTimeRounding;
    TrailPoints& points = all.emplace_back();
    if (!(frame.time < trail.until)) continue;
    for (auto way = ways_.lower_bound(from); way != ways_.end() && way->first <= now; ++way) {
      points.ages.push_back(std::max(frame.time - way->first, 0.0));
      points.places.push_back(way->second[i]);
    }
  }
  return all;
}

std::vector<ClipSimulation::Shutter> record(const Scene& scene,
                                            const std::vector<ClipFrame>& frames,
                                            const std::vector<int>& wanted,
                                            const ClipSimulation::Tick& tick) {
  ClipSimulation simulation(scene, frames, wanted, tick);
  std::vector<ClipSimulation::Shutter> all(wanted.size());
  while (!simulation.done()) {
    ClipSimulation::Shutter shutter = simulation.next();
    all[shutter.index] = std::move(shutter);
  }
  return all;
}

namespace {

/// Into how many equal steps the scene's method divides a frame; for methods that choose their
/// steps, into how many parts times are rounded.
std::uint64_t steps_per_frame(const Scene& scene) {
  constexpr std::uint64_t kFine = 1024;
  const double step = step_of(with_defaults(scene.method));
  return step > 0 ? step_count(1.0 / scene.fps, step) : kFine;
}

}  // namespace

double own_time(const Scene& scene, double time) {
  // A single quotient, so that a time has the same bits however it was come by.
  const double rate = double(steps_per_frame(scene)) * scene.fps;
  return std::round(time * rate) / rate;
}

std::vector<double> exposure_times(const Scene& scene, double time, double rate) {
  const double open = scene.stage ? scene.stage->shutter * rate / scene.fps : 0;
  if (open == 0) return {time};
  // A little more, as the quotient of a whole number of steps may fall short of it.
  const auto steps = unsigned(open * scene.fps * double(steps_per_frame(scene)) * (1 + 1e-9));
  const int states = std::min(int(std::bit_floor(std::max(steps, 1u))), scene.stage->exposures);
  std::vector<double> times;
  for (int i = 0; i < states; ++i) {
    times.push_back(std::max(own_time(scene, time + (i - states / 2) * open / states), 0.0));
  }
  return times;
}

}  // namespace taut::scenes
