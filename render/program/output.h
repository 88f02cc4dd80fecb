// How commands speak: exit codes, messages, results as JSON, and where a result goes.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <concepts>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "render/base/atomic_file.h"
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

  bool is_standard() const { return !file_; }
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

}  // namespace taut::program
