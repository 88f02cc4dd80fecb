// The contents of a clip: cards and shots, frame by frame.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// One frame of a clip.
struct ClipFrame {
  const Shot* shot = nullptr;
  double time = 0;             // s of the scene
  double rate = 0;             // seconds of the scene to one of the clip; 0: it stands still
  const Card* card = nullptr;  // over the picture
  double card_shown = 0;       // how much of the card there is to see, 0 to 1
};

/// The frames of the scene's clip: title, shots, end. Where there is one shot and no card, frame k
/// shows the time k/fps. The scene has a stage, and must outlive them.
std::vector<ClipFrame> clip_frames(const Scene& scene);

/// The times (s, rising) of all states that these frames show while their shutters are open.
std::vector<double> shown_times(const Scene& scene, const std::vector<ClipFrame>& frames);

// The states that the frames of a clip show, simulated while the frames are drawn.

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

// Which of a simulation's states a frame shows while its shutter is open.

/// The times (s) of the states that the frame at `time` is made of, evenly apart while the shutter
/// is open, the frame's own in the middle (the later one of two); `time` alone where the scene has
/// no shutter. `rate` is how fast the clip goes, in seconds of the scene to one of the clip.
///
/// The number of times is Stage::exposures, or the power of two that the method's steps suffice
/// for: methods of equal steps stop after their own steps, so that the shutter changes no bit of
/// the trajectory. Times before the scene's start become the start.
std::vector<double> exposure_times(const Scene& scene, double time, double rate = 1);

/// The time nearest to `time` (s) at which the scene's method ends a step by itself. Methods that
/// choose their steps end one anywhere; times are rounded for them, to far below a frame.
double own_time(const Scene& scene, double time);

}  // namespace taut::scenes
