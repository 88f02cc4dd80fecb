// A scene: a world, what happens to it, and a stage. Read from a TOML file.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/character/performance.h"
#include "scenes/method_choice.h"
#include "scenes/plan.h"
#include "scenes/stage.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut {

struct Scene {
  std::filesystem::path file;
  std::string title;
  double duration = 0;  // s
  int fps = 60;
  int width = 1920, height = 1080;
  MethodChoice method;
  World world;        // finished, at time 0
  Timeline timeline;  // pins and cuts, in the order of the file
  std::optional<Plan> plan;
  std::string strange_plan;  // why the file's plan cannot be read; empty: it can, or there is none
  std::optional<Stage> stage;
  std::vector<std::shared_ptr<const Performance>> performances;  // one per Stage::characters

  /// Number of frames: frame k shows time k/fps, for every k with k/fps < duration.
  int frames() const;
};

/// Number of frames, `fps` to a second, that begin in `duration` (s). A duration that is a whole
/// number of frames but for rounding has no frame at its end.
int frame_count(double duration, int fps);

/// The scene at its start, with its method, and what happens to it.
Simulation start(const Scene& scene);
/// The same by another method.
Simulation start(const Scene& scene, const MethodChoice& method);

/// The method of a scene that names none.
MethodChoice default_method();

/// The longest step that is at most `step` (s) and divides a frame of 1/`fps`; none where that
/// would change it by more than 2%.
std::optional<double> dividing_step(double step, int fps);
/// What to give instead, as messages say it.
std::string dividing_text(double step, int fps);

/// A value to read in place of the one in the file: its dotted key, and the value as TOML writes
/// it.
struct SceneChange {
  std::string key;    // connectors.rope.particles
  std::string value;  // 41
};

/// Reads and checks a scene. Throws BadScene. Of its assets only characters are looked at
/// unless `with_stage`.
Scene load_scene(const std::filesystem::path& file, bool with_stage,
                 const std::vector<SceneChange>& changes = {});

/// Reads a scene as its plan models and solves it. Throws BadScene, also where it has no plan or
/// changed since the plan was made.
Scene load_planned(const std::filesystem::path& file, bool with_stage);

}  // namespace taut
