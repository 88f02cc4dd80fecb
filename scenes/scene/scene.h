// A scene: a world, what happens to it, and a stage.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/character/skeleton.h"
#include "scenes/scene/plan.h"
#include "scenes/scene/stage.h"
#include "sim/choreography/flat_fit.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut::scenes {

// The names of connectors that the reader makes of one.

/// Whether it names a copy, a span behind a pulley or a cord of a net: these are numbered,
/// "cord#2".
inline bool is_numbered(std::string_view name) {
  return name.find('#') != std::string_view::npos;
}

/// The name that the scene file has for it: "cord" of "cord#2".
inline std::string_view written_name(std::string_view name) {
  return name.substr(0, name.find('#'));
}

// A choreography as a scene asks for it.

struct Choreographed {
  choreography::Choreography problem;
  double within = 0;           // m, of each waypoint
  std::filesystem::path file;  // where the keys found stand
};

struct Scene {
  std::filesystem::path file;
  std::string title;
  double duration = 0;  // s
  int fps = 60;
  int width = 1920, height = 1080;
  MethodChoice method;
  World world;                            // finished, at time 0
  Timeline timeline;                      // pins and cuts, in the order of the file
  std::vector<Simulation::Break> breaks;  // what settle_breaks() has made cuts of
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

/// Simulates a scene whose connectors may break (Connector::breaks_at) by its method, and makes
/// cuts of its timeline where they do: then each part is a connector from the first frame to the
/// last. Another scene stays as it is. The run ends where the method diverges.
void settle_breaks(Scene& scene);
/// The same by another method.
void settle_breaks(Scene& scene, const MethodChoice& method);

/// A value to read in place of the one in the file: its dotted key, and the value as TOML writes
/// it.
struct SceneChange {
  std::string key;    // connectors.rope.particles
  std::string value;  // 41
};

}  // namespace taut::scenes
