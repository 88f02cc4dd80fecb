// The contents of a clip: cards and shots, frame by frame.
#pragma once

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

}  // namespace taut::scenes
