// What a clip shows: cards and shots, frame by frame.
#pragma once

#include <functional>
#include <vector>

#include "scenes/scene.h"

namespace taut {

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

/// The states that each of the frames in `wanted` (rising) shows while its shutter is open, from
/// one simulation. It goes the same way whichever frames are wanted. Calls `tick` now and then, and
/// `watch`, where there is one, with the simulation at each of the times.
std::vector<std::vector<Snapshot>> record(const Scene& scene, const std::vector<ClipFrame>& frames,
                                          const std::vector<int>& wanted,
                                          const std::function<void()>& tick,
                                          const std::function<void(const Simulation&)>& watch = {});

}  // namespace taut
