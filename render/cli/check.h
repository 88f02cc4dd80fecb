// taut check: the faults of a scene, and its expected run.
#pragma once

#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/child.h"
#include "render/program/output.h"
#include "scenes/scene/scene.h"

namespace taut::cli {

// What a copy of this process tells the one that waits: records, so that what is said when the copy
// is stopped may be cut off anywhere.

/// Bytes that a copy may have beyond what the process has.
inline constexpr std::size_t kCopyMemory = 3e9;

enum class Said : char { mark = 'm', again = 'a', state = 's', diverged = 'd' };

inline void tell(const render::Say& say, Said what, std::string_view bytes) {
  const std::size_t size = bytes.size();
  std::string record(1, static_cast<char>(what));
  record.append(reinterpret_cast<const char*>(&size), sizeof size);
  record.append(bytes);
  say(record);
}

inline void tell(const render::Say& say, Said what, std::initializer_list<double> numbers) {
  tell(say, what,
       {reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(double)});
}

/// Calls visit(what, bytes) for every record that is whole.
template <typename Visit>
void each_record(std::string_view said, Visit visit) {
  constexpr std::size_t kHead = 1 + sizeof(std::size_t);
  while (said.size() >= kHead) {
    std::size_t size = 0;
    std::memcpy(&size, said.data() + 1, sizeof size);
    if (said.size() - kHead < size) return;
    visit(Said{said[0]}, said.substr(kHead, size));
    said.remove_prefix(kHead + size);
  }
}

inline std::vector<double> numbers_of(std::string_view bytes) {
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
  return numbers;
}

// The first piece of a run, in a copy of this process that is stopped when its time is over.

/// How far a run came.
struct Mark {
  double time = 0;  // s of the scene
  double cpu = 0;   // s, since the start of the run
};

struct Piece {
  std::vector<Mark> marks;       // rising; empty: not even the start was reached
  std::vector<Snapshot> states;  // at frames, as often as warnings look at them
  bool in_parts = false;         // the first frame took too long: the marks are within it
  double first_frame = 0;        // s of CPU time that did not suffice for it, then
  bool over = false;             // the run ends at the last mark, as `diverged` says
  std::string diverged;
  double unfinished = 0;  // s of CPU time behind the last mark
  double next = 0;        // s of the scene, from the last mark to the one that was not reached

  double until() const { return marks.empty() ? 0 : marks.back().time; }
};

/// The time (s) of the scene's last frame.
double end_of(const scenes::Scene& scene);

/// Does what taut simulate does with the scene, for `seconds` of CPU time at most.
Piece run_piece(const scenes::Scene& scene, double seconds);

// The time that taut simulate takes, measured on a piece of the run.

struct RunTime {
  double seconds = 0;          // of CPU time, of the whole run; between the next two
  double least = 0, most = 0;  // as parts of the piece tell
  double simulated = 0;        // s of the scene that were run to find it
  bool whole = false;          // that is all of the scene, or as far as it goes
  bool diverges = false;       // the run ends there by an error
  /// Too little was run to tell more than that it takes longer.
  bool at_least = false;
  std::string unknown;  // why nothing was run; empty: it was
};

/// Why no piece of the scene's run can be tried, or empty.
std::string why_not_tried(const scenes::Scene& scene);

/// What the whole run takes, as its piece tells. `started` (s) is the CPU time of starting the
/// program and reading the scene.
RunTime time_of_run(const scenes::Scene& scene, double started, const Piece& piece);

/// As in "9.1 s, as its first 0.41 s tell".
std::string text_of(const RunTime& time);

// A cheaper method for a scene, as far as a piece of its run shows that the two agree.

struct Cheaper {
  MethodChoice method;
  double seconds = 0;  // of CPU time, of the whole run
  double apart = 0;    // m, at most: RMS of all particles and bodies at a frame
  double until = 0;    // s of the scene, as far as the two were compared
};

/// A method with which the run would take less than a twentieth of `time`, and whose states are no
/// more than 1% of the longest connector from those of the piece. `started` (s): as time_of_run()
/// takes it. `seconds`: CPU time to look for such a method.
std::optional<Cheaper> cheaper_method(const scenes::Scene& scene, const RunTime& time,
                                      double started, const Piece& piece, double seconds);

/// What to tell of it.
std::string text_of(const Cheaper& cheaper, const RunTime& time, const scenes::Scene& scene);

/// The settings that a run of more than a minute may be shortened with, as a sentence; or nothing.
std::string what_helps(const scenes::Scene& scene, const RunTime& time);

}  // namespace taut::cli

namespace taut::cli::check_command {

// What taut check says of a world's connectors.

/// A line for each connector; one for all of a net, and for copies that stand side by side.
std::vector<std::string> connector_lines(const World& world);

/// Stiffnesses and drag of a connector that has some: at its first link, if it tapers.
program::Json material_json(const Connector& connector);

}  // namespace taut::cli::check_command

namespace taut::cli {

// The table of methods by features.

/// Two tables in Markdown: the features that each method follows, and those that it does not follow
/// together.
std::string features_as_markdown();

}  // namespace taut::cli
