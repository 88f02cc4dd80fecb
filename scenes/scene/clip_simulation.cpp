#include "scenes/scene/clip_simulation.h"

#include <algorithm>
#include <tuple>

#include "scenes/scene/exposure.h"

namespace taut::scenes {

// The simulation stops for every frame of the clip: methods that choose their steps would go
// another way without the stops.
ClipSimulation::ClipSimulation(const Scene& scene, const std::vector<ClipFrame>& frames,
                               const std::vector<int>& wanted, Tick tick, Watch watch)
    : scene_(scene),
      tick_(std::move(tick)),
      watch_(std::move(watch)),
      stops_(shown_times(scene, frames)),
      simulation_(start(scene)) {
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
    if (time >= times.front()) states_.emplace_hint(states_.end(), time, simulation_.state());
  }
  Shutter shutter{wanted.index, {}};
  for (const double time : times) shutter.states.push_back(states_.at(time));
  ++next_;
  return shutter;
}

std::vector<std::vector<Snapshot>> record(const Scene& scene, const std::vector<ClipFrame>& frames,
                                          const std::vector<int>& wanted,
                                          const ClipSimulation::Tick& tick) {
  ClipSimulation simulation(scene, frames, wanted, tick);
  std::vector<std::vector<Snapshot>> states(wanted.size());
  while (!simulation.done()) {
    ClipSimulation::Shutter shutter = simulation.next();
    states[shutter.index] = std::move(shutter.states);
  }
  return states;
}

}  // namespace taut::scenes
