// A scene: a world, what happens to it, and a stage. Read from a TOML file.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/character/performance.h"
#include "scenes/stage.h"
#include "sim/method.h"
#include "sim/trajectory.h"
#include "sim/world.h"

namespace taut {

struct MethodChoice {
  std::string name;
  Settings settings;  // those that the scene names, validated against the method's list
};

struct Scene {
  std::filesystem::path file;
  std::string title;
  double duration = 0;  // s
  int fps = 60;
  int width = 1920, height = 1080;
  MethodChoice method;
  World world;  // finished, at time 0
  std::optional<Stage> stage;
  std::vector<std::shared_ptr<const Performance>> performances;  // one per Stage::characters

  /// Number of frames: frame k shows time k/fps, for every k with k/fps < duration.
  int frames() const;
};

/// Reads and checks a scene. Throws BadScene or BadAsset. Assets are loaded only when `with_stage`.
Scene load_scene(const std::filesystem::path& file, bool with_stage);

}  // namespace taut
