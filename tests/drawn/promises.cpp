#include "tests/drawn/promises.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/base/child.h"
#include "scenes/format/document.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/run/error_estimate.h"
#include "tests/bench/promise/reference.h"
#include "tests/drawn/watch.h"

namespace taut::drawn {
namespace {

// In s of CPU time, as is kShare of a run, and twice that of its error's:
constexpr double kTogether = kSlower / 2;   // of all runs of a scene, of which most take far less
constexpr double kAlone = kSlower / 4;      // of a run for which that was too little
constexpr double kPatience = 20 * kSlower;  // of a slice of it: what takes more hangs

constexpr std::size_t kMemory = 1024u << 20;  // bytes
constexpr double kMostTolerances = 10;        // that an error may have of which nothing is told
constexpr double kTold = 1. / 3;              // of an error, that its estimate has at least

// Findings beside broken promises.
constexpr const char* kDiverged = "diverged\t";
constexpr const char* kEnded = "ended\t\n";
constexpr const char* kUnknown = "unknown\t\n";
constexpr const char* kMissed = "missed\t\n";
constexpr const char* kTolerated = "told\t\n";

std::string run_twice(const scenes::Scene& scene, const MethodChoice& method) {
  const bool claims = method.name == "direct" || method.name == "truth";
  Watch first(scene, method);
  try {
    std::string told = first.look(scene.frames());
    const auto reached = static_cast<int>(first.hashes().size());
    Watch second(scene, method);
    second.look(reached);
    const std::size_t both = std::min(first.hashes().size(), second.hashes().size());
    if (!std::equal(first.hashes().begin(), first.hashes().begin() + std::ptrdiff_t(both),
                    second.hashes().begin())) {
      told += "same\tother bits\n";
    }
    return told + (reached == scene.frames() ? kEnded : "");
  } catch (const Diverged& error) {
    const std::string_view why = error.what();
    const auto says = [&](std::string_view words) { return why.find(words) != why.npos; };
    // With contact and of strings the truth does not find every motion, and where rigid links
    // are joined there may be none: both say where they stop.
    const bool stops =
        method.name == "truth" &&
        (has_contact(scene.world) || !scene.world.joints.empty() || has_strings(scene.world));
    const bool tells = says("inside of obstacle") ||
                       says("the links may be at their full length") ||
                       says("at full length between two places") ||
                       says("a link is pressed together to nothing") || says(kRunThrough);
    const bool excused = !claims || stops || tells || first.is_at_full_length(error.time);
    return (excused ? kDiverged : "follows\t") + std::string(error.what()) + '\n';
  } catch (const BadIntervention& error) {
    return kDiverged + std::string(error.what()) + '\n';
  } catch (const std::exception& error) {
    return fmt::format("ends\t{}\n", error.what());
  }
}

/// The largest error (m) that the method's own estimate has told by its `frame`th frame, or where
/// its companion is compared next.
double told_error(const study::Problem& problem, const Settings& settings, std::size_t frame) {
  Simulation simulation(problem.world, make_method("direct", settings), problem.timeline);
  ErrorEstimate estimate(problem.world, "direct", settings, problem.timeline);
  constexpr std::size_t kNext = 4;
  for (std::size_t k = 0; k < std::min(frame + kNext, problem.times.size()); ++k) {
    simulation.advance_to(problem.times[k]);
    estimate.follow(simulation);
  }
  return estimate.largest();
}

/// How far `direct` is off, as far as the truth gets. A step's error of a tolerance grows as the
/// motion has it: more than kTolerances may come of that, where the run's own estimate says so.
std::string compare(const scenes::Scene& scene) {
  const study::Problem problem{scene.world, study::frame_times(scene.duration, scene.fps),
                               scene.timeline};
  const double length = length_scale(scene.world);
  const promise::Reference reference = promise::make_reference(problem, length, 2 * kShare);
  if (reference.frames.size() <= promise::kLeast) return kUnknown;
  const Settings settings = with_defaults(*find_method("direct"), scene.method.settings);
  const study::Run found = study::run(problem, {"direct", settings}, kShare);
  const double tolerance = number(settings, "tolerance");
  const auto distance = [](const Vec3& a, const Vec3& b, double) { return (a - b).norm(); };
  double largest = 0;
  std::size_t at = 0;
  for (std::size_t k = 0; k < std::min(reference.frames.size(), found.frames.size()); ++k) {
    const double error = study::frame_error(found.frames[k], reference.frames[k], distance);
    if (error <= largest) continue;
    largest = error;
    at = k;
  }
  if (largest <= kTolerances * tolerance) return "";
  if (told_error(problem, settings, at) >= kTold * largest) return kTolerated;
  if (largest <= kMostTolerances * tolerance) return kMissed;
  return fmt::format("error\tframe {}: {:.3g} m, expected at most {:.3g}, growth {:.3g}\n", at,
                     largest, kMostTolerances * tolerance, reference.growth);
}

/// Whether the method says that it takes such a scene.
bool takes(const MethodInfo& method, const World& world) {
  return method.missing.empty() && method.name != "sdfast" && follows(method, world);
}

/// A run of a scene, or a comparison of one with the truth.
struct Task {
  MethodChoice method;
  bool compares = false;
};

/// The outcome of the task: method, promise and finding, a line each.
std::string perform(const scenes::Scene& scene, const Task& task) {
  const std::string found = task.compares ? compare(scene) : run_twice(scene, task.method);
  std::string told;
  for (std::size_t at = 0; at < found.size();) {
    const std::size_t next = found.find('\n', at) + 1;
    told += task.method.name + '\t' + found.substr(at, next - at);
    at = next;
  }
  return told;
}

std::vector<Broken> parse(const std::string& told) {
  std::vector<Broken> found;
  for (std::size_t at = 0; at < told.size();) {
    const std::size_t promise = told.find('\t', at) + 1, what = told.find('\t', promise) + 1;
    const std::size_t next = told.find('\n', what) + 1;
    found.push_back({told.substr(at, promise - at - 1), told.substr(promise, what - promise - 1),
                     told.substr(what, next - what - 1)});
    at = next;
  }
  return found;
}

render::Bounded apart(double cpu_time, const std::function<std::string()>& work) {
  return render::run_bounded({cpu_time, kMemory}, [&](const render::Say& say) { say(work()); });
}

/// The outcome of a task in a process of its own. Where a frame takes longer than a run may, the
/// run has to go on in slices; and a run that ends in slices ought to end in frames.
std::vector<Broken> alone(const scenes::Scene& scene, const Task& task) {
  using End = render::Bounded::End;
  const auto ends = [&](const std::string& how) {
    return std::vector<Broken>{{task.method.name, "ends", how}};
  };
  render::Bounded result = apart(kAlone, [&] { return perform(scene, task); });
  if (result.end == End::no_time && task.compares) return {{task.method.name, "unknown", ""}};
  if (result.end == End::no_time) {
    result = apart(kAlone + kPatience, [&] {
      try {
        return std::string(Watch(scene, task.method).slice() ? "done" : "");
      } catch (const std::runtime_error&) {  // it says why, as it does in frames, later
        return std::string();
      }
    });
    if (result.end == End::no_time && task.method.name == "multibody") return {};
    if (result.end == End::no_time) {
      return ends(fmt::format("{} s of the scene not within {} s", kSlice, kPatience));
    }
    if (result.end == End::done) {
      return result.said.empty() ? std::vector<Broken>{} : ends("in slices, but not in frames");
    }
  }
  if (result.end == End::done) return parse(result.said);
  return ends(result.end == End::no_memory ? std::string("not within 1 GB")
                                           : std::string("by a fault"));
}

/// Most tasks do well, all in one process; else each has its own.
std::vector<Broken> all(const scenes::Scene& scene, const std::vector<Task>& tasks) {
  const render::Bounded together = apart(kTogether, [&] {
    std::string told;
    for (const Task& task : tasks) told += perform(scene, task);
    return told;
  });
  if (together.end == render::Bounded::End::done) return parse(together.said);
  std::vector<Broken> found;
  for (const Task& task : tasks) std::ranges::move(alone(scene, task), std::back_inserter(found));
  return found;
}

}  // namespace

Verdict check_promises(const std::string& text, const std::string& only) {
  Verdict verdict;
  std::optional<scenes::Scene> scene;
  try {
    scene = scenes::read_scene(scenes::parse_document("drawn.toml", text), false);
  } catch (const scenes::BadScene& error) {
    verdict.refusal = error.what();
    return verdict;
  }
  std::vector<Task> tasks;
  for (const MethodInfo& method : all_methods()) {
    if (!takes(method, scene->world) || (!only.empty() && method.name != only)) continue;
    MethodChoice choice{std::string(method.name), {}};
    if (method.name == scene->method.name) choice = scene->method;
    choice.settings = with_defaults(method, choice.settings);
    tasks.push_back({choice, false});
    ++verdict.runs;
  }
  if (scene->method.name == "direct" && !has_contact(scene->world) &&
      (only.empty() || only == "direct") && takes(*find_method("truth"), scene->world)) {
    tasks.push_back({scene->method, true});
    ++verdict.compared;
  }
  for (Broken& found : all(*scene, tasks)) {
    if (found.promise == "ended") {
      ++verdict.ended;
    } else if (found.promise == "diverged") {
      ++verdict.diverged;
    } else if (found.promise == "unknown") {
      --verdict.compared;
    } else if (found.promise == "told") {
      ++verdict.told;
    } else if (found.promise == "missed") {
      ++verdict.missed;
    } else {
      verdict.broken.push_back(std::move(found));
    }
  }
  return verdict;
}

}  // namespace taut::drawn
