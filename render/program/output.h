// How commands speak: exit codes, messages, progress, results as JSON, and where a result goes.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "render/base/atomic_file.h"
#include "render/chart/table.h"
#include "sim/motion/printable.h"

namespace taut::program {

// How the program ends. Scripts rely on these numbers.

enum ExitCode : int {
  kDone = 0,
  kDiffers = 1,      // a golden, or a known answer
  kUsage = 2,        // also every code of the option parser
  kBadScene = 3,     // or a bad asset
  kNoContext = 4,    // no rendering context
  kEncoder = 5,      // FFmpeg missing or failed
  kCannotWrite = 6,  // an output could not be written
  kDiverged = 7,     // the simulation diverged
  kNoMemory = 8,
  kInternal = 70,  // a defect of taut itself
  kInterrupted = 130,
  kTerminated = 143,
};

// Words for whoever runs the program.

/// A text of several lines, whose newlines note() leaves.
struct Lines {
  std::string_view text;
};

/// A value as note() writes it: text without anything that a terminal would obey.
template <class Value>
auto shown(const Value& value) {
  if constexpr (std::same_as<Value, Lines>) {
    return printable_lines(value.text);
  } else if constexpr (std::convertible_to<const Value&, std::string_view>) {
    return printable(value);
  } else {
    return value;
  }
}

/// Writes to standard error. A run goes on where nobody can read it; fmt::print
/// throws there.
template <class... Values>
void note(fmt::format_string<decltype(shown(std::declval<const Values&>()))...> format,
          const Values&... values) {
  const std::string text = fmt::format(format, shown(values)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

// Results as JSON: numbers are numbers, with their units in their keys, and what there is none of
// is null. results.schema.json describes them all.

using Json = nlohmann::ordered_json;

inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// As results are written, indented. Bytes of names that are no UTF-8 become U+FFFD.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

/// A file, or standard output where the name is - or what that goes to.
class Output {
 public:
  explicit Output(const std::string& name);

  std::uint64_t written() const { return written_; }

  /// Throws CannotWrite, as does finish().
  void write(std::string_view bytes);
  /// Until then there is no file of that name.
  void finish();

 private:
  std::optional<render::AtomicFile> file_;
  std::uint64_t written_ = 0;
};

/// Writes a result in words to standard output: names with escapes (see printable_lines()). Throws
/// CannotWrite.
void write_text(std::string_view text);

/// True where such an output goes to standard output.
bool to_standard_output(const std::string& name);

// The terminal, and the progress of long work on standard error.

/// True if text on this stream (1 or 2) may be coloured: on a terminal unless NO_COLOR is set, and
/// always if CLICOLOR_FORCE is set.
bool is_colored(int stream);

/// The table as standard output shows it: in lines no wider than the terminal, or than COLUMNS
/// says, the names of its columns bold where there are colours. A pipe or file gets whole lines.
std::string table_text(const chart::Table& table);

class Progress {
 public:
  /// `what` as in "rendering", `unit` as in "frames". Silent when `quiet`.
  Progress(std::string what, std::string unit, std::uint64_t total, bool quiet);
  /// Clears the progress line. If an interruption ends the work, left_off() tells how far it was.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Shows that `done` of the total are finished.
  void update(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_, unit_;
  std::uint64_t total_, done_ = 0;
  int exceptions_ = std::uncaught_exceptions();
  bool quiet_, terminal_;
  bool shown_ = false;
  Clock::time_point start_, last_;
};

/// The progress of the innermost work that an interruption ended: "simulating: 3 of 60 frames".
/// Empty if none was interrupted.
const std::string& left_off();

/// A duration as h:mm:ss or m:ss.
std::string clock_text(double seconds);

}  // namespace taut::program
