// The states that the frames of a clip show, simulated while the frames are drawn.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "scenes/scene/clip.h"

namespace taut::scenes {

/// Gives the states of frame after frame, in the order of the scene's time: shots may go back in
/// time, a simulation does not. Only the states of one open shutter are kept.
class ClipSimulation {
 public:
  using Tick = std::function<void()>;
  using Watch = std::function<void(const Simulation&)>;

  /// `wanted` are frames of the clip, in any order. The simulation goes the same way whichever
  /// frames are wanted. Calls `tick` now and then, and `watch`, where there is one, with the
  /// simulation at each time that a frame of the clip shows. `scene` and `frames` must outlive it.
  ClipSimulation(const Scene& scene, const std::vector<ClipFrame>& frames,
                 const std::vector<int>& wanted, Tick tick, Watch watch = {});

  bool done() const { return next_ == order_.size(); }

  struct Shutter {
    std::size_t index = 0;         // of the frame in `wanted`
    std::vector<Snapshot> states;  // that it shows while its shutter is open, their times rising
    std::vector<TrailPoints> trails = {};  // of the stage, until the frame's time
  };
  /// Unless done. Throws as Simulation::advance_to() does.
  Shutter next();

 private:
  std::vector<TrailPoints> trails(const ClipFrame& frame);

  struct Wanted {
    double opens;  // s, of the frame's first state
    std::size_t index;
    const ClipFrame* frame;
  };

  const Scene& scene_;
  Tick tick_;
  Watch watch_;
  std::vector<Wanted> order_;
  std::size_t next_ = 0;       // of the order
  std::vector<double> stops_;  // s, times at which the simulation stops
  std::size_t stop_ = 0;       // the next of them
  Simulation simulation_;
  std::map<double, Snapshot> states_;  // by time: those that this shutter or a later one shows
  std::map<double, std::vector<Vec3>> ways_;  // by time: where the points are that leave trails
  double longest_trail_ = 0;                  // s
};

/// What all wanted frames show at once, in the order of `wanted`.
std::vector<ClipSimulation::Shutter> record(const Scene& scene,
                                            const std::vector<ClipFrame>& frames,
                                            const std::vector<int>& wanted,
                                            const ClipSimulation::Tick& tick);

}  // namespace taut::scenes
