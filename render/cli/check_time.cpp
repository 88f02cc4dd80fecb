#include "render/cli/check_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "render/base/bounded.h"
#include "render/export/csv.h"
#include "render/options/needs.h"
#include "sim/run/error_estimate.h"

namespace taut::cli {
namespace {

constexpr double kPiece = 1;          // s of CPU time
constexpr std::size_t kMemory = 3e9;  // bytes, of the piece
constexpr double kMostMemory = 1e9;   // bytes; of what takes more, no piece is run
constexpr double kUnsaid =
    0.02;  // s of CPU time, from the last mark to the end of the piece, at most
constexpr double kBetween = 2e-3;        // s of CPU time between two marks
constexpr double kFirstPiece = 0x1p-20;  // of a frame

/// How far the piece came.
struct Mark {
  double time = 0;  // s of the scene
  double cpu = 0;   // s
};

/// The run of taut simulate, as far as its cost goes.
class Run {
 public:
  Run(const scenes::Scene& scene, const render::Say& say)
      : say_(say),
        simulation_(scenes::start(scene)),
        estimate_(scene.world, scene.method.name, scene.method.settings, scene.timeline) {
    mark(0, true);
  }

  void go_to(double time, bool is_frame) {
    simulation_.advance_to(time);
    if (is_frame) {
      estimate_.follow(simulation_);
      written_ += exporting::csv_row(simulation_.state()).size();
    }
    mark(time, !is_frame);
  }

  void mark(double time, bool always) {
    const double now = render::process_seconds();
    if (!always && now - said_ < kBetween) return;
    said_ = now;
    say_(fmt::format("{} {}\n", time, now));
  }

 private:
  const render::Say& say_;
  Simulation simulation_;
  ErrorEstimate estimate_;
  double said_ = 0;
  std::size_t written_ = 0;
};

double end_of(const scenes::Scene& scene) {
  return static_cast<double>(scene.frames() - 1) / scene.fps;
}

void run_frames(const scenes::Scene& scene, const render::Say& say) {
  Run run(scene, say);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    run.go_to(static_cast<double>(frame) / scene.fps, true);
  }
  run.mark(end_of(scene), true);
}

/// Of a scene whose first frame takes longer than the piece: parts of that frame that double, whole
/// steps where all steps are equal.
void run_parts(const scenes::Scene& scene, const render::Say& say) {
  Run run(scene, say);
  const double frame = 1.0 / scene.fps, step = step_of(with_defaults(scene.method));
  double part = step > 0 ? step : kFirstPiece * frame;
  for (double time = part; time < frame; time += part) {
    run.go_to(time, false);
    part *= 2;
  }
}

/// What a copy of this process that does `work` said of its way.
std::vector<Mark> marks_of(const scenes::Scene& scene,
                           void (*work)(const scenes::Scene&, const render::Say&), bool& is_over) {
  const render::Bounded piece = render::run_bounded({kPiece, kMemory}, [&](const render::Say& say) {
    try {
      work(scene, say);
    } catch (const Diverged&) {  // the run ends there as well
      say("end\n");
    } catch (const BadIntervention&) {
      say("end\n");
    }
  });
  std::vector<Mark> marks;
  std::istringstream lines(piece.said);
  for (Mark mark; lines >> mark.time >> mark.cpu;) marks.push_back(mark);
  is_over = piece.said.ends_with("end\n");
  return marks;
}

/// The cost of a simulated second at the end of the piece, in CPU seconds.
double rate_at_end(const std::vector<Mark>& marks) {
  const Mark& last = marks.back();
  const double half = (marks.front().cpu + last.cpu) / 2;
  auto from = std::ranges::find_if(marks, [&](const Mark& mark) { return mark.cpu > half; });
  if (from != marks.begin()) --from;
  return last.time > from->time ? (last.cpu - from->cpu) / (last.time - from->time) : 0;
}

}  // namespace

RunTime time_of_run(const scenes::Scene& scene, double started) {
  RunTime result;
  if (const double memory = options::simulation_needs(scene).memory; memory > kMostMemory) {
    result.unknown = "takes too much memory to be tried";
    return result;
  }
  const double end = end_of(scene);
  bool is_over = false;
  std::vector<Mark> marks = marks_of(scene, run_frames, is_over);
  const auto all_of = [&](const std::vector<Mark>& some) {
    return !some.empty() && (is_over || some.back().time >= end);
  };
  if (all_of(marks)) {
    const double all = started + marks.back().cpu;
    return {all, all, all, marks.back().time, true, false, ""};
  }
  const bool in_parts = marks.empty() || marks.back().time == 0;
  if (in_parts) marks = marks_of(scene, run_parts, is_over);
  if (marks.empty()) {  // not even its start
    result.seconds = result.least = result.most = started + kPiece;
    result.at_least = true;
    return result;
  }
  const Mark& last = marks.back();
  result.simulated = last.time;
  // What came after the last mark was not enough for the next one.
  double next = 1.0 / scene.fps;
  if (in_parts) {
    const double step = step_of(with_defaults(scene.method));
    next = last.time > 0 ? last.time : step > 0 ? step : kFirstPiece / scene.fps;
  }
  const double unfinished = is_over ? 0 : std::max(kPiece - kUnsaid - last.cpu, 0.0);
  const double left = end - last.time;
  const double seen = std::max(marks.size() > 1 ? rate_at_end(marks) : 0, unfinished / next);
  const double average = (kPiece - marks.front().cpu) / (last.time + next);
  result.least = started + kPiece + std::min(average, seen) * left;
  result.most = started + kPiece + std::max(average, seen) * left;
  result.at_least = in_parts && unfinished > kPiece / 2;
  result.seconds = result.at_least ? result.least : std::sqrt(result.least * result.most);
  return result;
}

std::string text_of(const RunTime& time) {
  if (!time.unknown.empty()) return "a time that is not known: it " + time.unknown;
  const std::string text = options::time_text(time.seconds);
  if (time.whole) return text;
  if (time.simulated == 0)
    return fmt::format("more than {}: its first step takes more than {} s", text, kPiece);
  const std::string by = fmt::format("as its first {:.2g} s tell", time.simulated);
  if (time.at_least) return fmt::format("{} or more, {}", text, by);
  constexpr double kSame = 2;
  if (time.most < kSame * time.least) return fmt::format("{}, {}", text, by);
  return fmt::format("{} to {}, {}", options::time_text(time.least), options::time_text(time.most),
                     by);
}

}  // namespace taut::cli
