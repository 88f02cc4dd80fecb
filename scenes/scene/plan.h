// A plan: the cheapest model of a scene that nobody can tell from the reference solution, as `taut
// plan` found it, kept in the scene file's table [plan].
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/run/method.h"
#include "sim/run/reduced.h"

namespace taut::scenes {

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

}  // namespace taut::scenes
