#include "render/cli/check_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/options/needs.h"

namespace taut::cli {
namespace {

constexpr double kMostMemory = 1e9;  // bytes; of what takes more, no piece is run

/// The cost of a simulated second at the end of the piece, in CPU seconds.
double rate_at_end(const std::vector<Mark>& marks) {
  const Mark& last = marks.back();
  const double half = (marks.front().cpu + last.cpu) / 2;
  auto from = std::ranges::find_if(marks, [&](const Mark& mark) { return mark.cpu > half; });
  if (from != marks.begin()) --from;
  return last.time > from->time ? (last.cpu - from->cpu) / (last.time - from->time) : 0;
}

}  // namespace

std::string why_not_tried(const scenes::Scene& scene) {
  return options::simulation_needs(scene).memory > kMostMemory ? "takes too much memory to be tried"
                                                               : "";
}

RunTime time_of_run(const scenes::Scene& scene, double started, const Piece& piece) {
  RunTime result;
  const double end = end_of(scene);
  if (piece.marks.empty()) {  // not even its start
    result.seconds = result.least = started + piece.unfinished;
    result.at_least = true;
    return result;
  }
  const Mark& last = piece.marks.back();
  if (piece.over || last.time >= end) {
    const double run = started + last.cpu;
    return {run, run, run, last.time, true, piece.over, false, ""};
  }
  result.simulated = last.time;
  const double left = end - last.time, tried = started + last.cpu + piece.unfinished;
  // What came after the last mark was not enough for the next one.
  const double seen = std::max(piece.marks.size() > 1 ? rate_at_end(piece.marks) : 0,
                               piece.unfinished / piece.next);
  const double average =
      (last.cpu + piece.unfinished - piece.marks.front().cpu) / (last.time + piece.next);
  result.least = tried + std::min(average, seen) * left;
  result.most = tried + std::max(average, seen) * left;
  // The end of the piece tells more of what follows than its beginning.
  constexpr double kEnd = 0.75;
  result.seconds = tried + std::pow(seen, kEnd) * std::pow(average, 1 - kEnd) * left;
  if (last.time == 0) {  // not even a step
    const double step = std::max(piece.unfinished, piece.first_frame);
    const double steps = std::max(options::steps_per_frame(scene), 1.0);
    result.seconds = result.least = tried + step * steps * (scene.frames() - 1);
    result.at_least = true;
  } else if (piece.in_parts && !(step_of(with_defaults(scene.method)) > 0)) {
    // Steps begin far shorter than they become. A frame takes one at least, and so did every part.
    const double parts = static_cast<double>(piece.marks.size());
    const double step = std::max(piece.unfinished, (last.cpu - piece.marks.front().cpu) / parts);
    result.seconds = result.least = tried + step * left * scene.fps;
    result.at_least = true;
  }
  return result;
}

std::string text_of(const RunTime& time) {
  if (!time.unknown.empty()) return "a time that is not known: it " + time.unknown;
  const std::string text = options::time_text(time.seconds);
  if (time.diverges)
    return fmt::format("{}, until it fails behind the frame at {:.3g} s", text, time.simulated);
  if (time.whole) return text;
  if (time.simulated == 0) {
    return fmt::format(
        "more than {}; how much more is not known, as the first step takes longer than a check may",
        text);
  }
  const std::string by = fmt::format("as its first {:.2g} s tell", time.simulated);
  if (time.at_least) return fmt::format("{} or more, {}", text, by);
  constexpr double kSame = 2;
  if (time.most < kSame * time.least) return fmt::format("{}, {}", text, by);
  return fmt::format("{} to {}, {}", options::time_text(time.least), options::time_text(time.most),
                     by);
}

}  // namespace taut::cli
