// A scene: a world, what happens to it, a stage, and the plan that its file carries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/character/skeleton.h"
#include "scenes/scene/stage.h"
#include "sim/choreography/flat_fit.h"
#include "sim/run/method.h"
#include "sim/run/reduced.h"
#include "sim/run/simulation.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut::scenes {

// A plan: the cheapest model of a scene that nobody can tell from the reference solution, as `taut
// plan` found it, kept in the scene file's table [plan].

// Which method a scene asks for.

/// The method of a scene that names none.
MethodChoice default_method();

/// The longest step that is at most `step` (s) and divides a frame of 1/`fps`; none where that
/// would change it by more than 2%.
std::optional<double> dividing_step(double step, int fps);
/// The step to give instead, as messages say it.
std::string dividing_text(double step, int fps);

/// Of a planned frame. Each is a share of what a pixel shows: more would change none by more than a
/// 32nd of its contrast, however far things come.
constexpr int kMostStates = 32;

struct Plan {
  std::string tolerance;  // "1px", "0.5mm"
  double error = 0;       // the largest until `until`, in the tolerance's unit
  double until = 0;       // s: as long as the motion is predictable
  std::string end = {};   // what makes an end of that, as "a pin comes"; empty: it ends by itself

  /// The statistics of the rest, where it is not predictable: relative differences from reference
  /// solutions.
  struct Afterwards {
    enum class Work { none, known, unknown };  // that is done on the scene
    Work work = Work::none;
    double energy =
        0;  // of what it can turn into motion; without known work, of the mean if unknown
    double stretch = 0;  // of a link's length
    double speeds = 0;   // of all points at all frames, that have another speed
  };
  std::optional<Afterwards> afterwards = {};

  int exposures = 0;          // that a frame needs at most; 0: it has no shutter
  std::uint64_t stamp = 0;    // of what it was made from
  std::uint64_t program = 0;  // of how its method moves, see method_stamp()
  MethodChoice method = {};
  std::map<std::string, std::size_t> particles = {};  // of each; 0: a massless span
  std::vector<std::string> links = {};                // bodies that are links
  std::vector<Physics> neglected = {};                // of all connectors
};

/// A tolerance as people write it.
struct Length {
  double number = 0;
  std::string_view unit;  // "px" or "mm"
};
/// "1px", "0.5mm"; none where it is neither or not above zero.
std::optional<Length> read_length(std::string_view text);

/// "within 0.4 px of the reference solution until 4.1 s; afterwards energy within 0.1%, stretch
/// within 0.01%, speeds within 4%".
std::string certificate(const Plan& plan);

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
