// The commands that make what pages show, as a shell takes them.
#pragma once

#include <string>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/run/method_choice.h"

namespace taut::options {

/// Which scene: its file, and what --set puts in place of its values.
struct ShownScene {
  std::string file;
  std::vector<std::string> set;
};

/// A run's cost and its errors from `share` of the length up.
std::string score_command(const ShownScene& scene, const MethodChoice& candidate, double share);

/// The class of a run of `duration` (s) of the scene with changes, stopped after `cap` (s) of CPU
/// time; with `scored`, told accurate from plausible.
std::string classify_command(const ShownScene& scene,
                             const std::vector<scenes::SceneChange>& changes,
                             const std::string& label, const MethodChoice& candidate,
                             double duration, double cap, bool scored);

/// A word as a shell takes it for one.
std::string quoted(const std::string& word);

}  // namespace taut::options
