// taut chart: speed against accuracy.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "render/atomic_file.h"
#include "render/cli/accuracy_page.h"
#include "render/cli/command.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/interrupt.h"
#include "sim/study/speed_accuracy.h"
#include "sim/truth/truth.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  // shares of the length

struct Options {
  StudyOptions study;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Every setting of a contender's sweep, with what its form sets put over it.
std::vector<Candidate> candidates_of(const Contender& contender, bool quick) {
  std::vector<Candidate> all;
  for (Candidate candidate : sweep(*contender.method, quick)) {
    for (const auto& [name, value] : contender.candidate.settings) candidate.settings[name] = value;
    const auto same = [&](const Candidate& other) { return other.settings == candidate.settings; };
    if (std::ranges::none_of(all, same)) all.push_back(std::move(candidate));
  }
  return all;
}

/// The scene up to the horizon of its truth.
struct Target {
  Problem problem;
  Reference reference;
};

Target target_of(const Scene& scene, double length, bool quick) {
  Target target{{scene.world, frame_times(scene.duration, scene.fps)}, {}};
  TruthOptions options;
  options.scored_error = length * (quick ? 1e-4 : 1e-6);
  if (quick) options.second_accuracy = 1e-7;
  Truth truth = solve_truth(scene.world, target.problem.times, options);
  target.reference = {std::move(truth.frames), truth.horizon, truth.self_error};
  std::erase_if(target.problem.times, [&](double time) { return time > truth.horizon; });
  target.reference.frames.resize(target.problem.times.size());
  return target;
}

std::vector<AccuracyRow> rows_of(const Contender& contender, const Target& target,
                                 const Metric& metric, double seconds, bool quick) {
  std::vector<AccuracyRow> rows;
  if (!contender.method->missing.empty()) return rows;
  const std::vector<Candidate> candidates = candidates_of(contender, quick);
  const double cap = seconds / 4;
  const Clock::time_point start = Clock::now();
  for (const Candidate& candidate : candidates) {
    stop_if_interrupted();
    if (seconds_since(start) > seconds) {
      rows.push_back({candidate,
                      Run::End::over_cap,
                      "the method's share of the budget was spent",
                      {std::numeric_limits<double>::infinity()},
                      {},
                      0,
                      0,
                      0});
      continue;
    }
    rows.push_back(score(target.problem, target.reference, std::span(&metric, 1), candidate, cap));
  }
  return rows;
}

int run(const Options& options, const Common& common) {
  const Clock::time_point start = Clock::now();
  const Scene scene = study_scene(options.study);
  const std::vector<Contender> contenders = chosen_contenders(options.study);
  const double length = scene.world.connectors.front().length;
  if (!(length > 0)) throw Misuse("a joint has no length to measure errors by");
  if (!common.quiet) fmt::print(stderr, "solving the truth\n");
  const Target target = target_of(scene, length, options.study.quick);
  if (target.problem.times.size() < 2) {
    throw Misuse(fmt::format("{}: nothing is predictable: the horizon of the truth is {} s",
                             options.study.scene, target.reference.horizon));
  }

  AccuracyStudy study;
  study.scene = options.study.scene;
  study.title = scene.title;
  study.horizon = target.reference.horizon;
  study.self_error = target.reference.self_error / length;
  study.particles = scene.world.connectors.front().particles();
  study.targets.assign(std::begin(kTargets), std::end(kTargets));
  const Metric metric = share_of_length(length);
  // Two thirds of the time find errors, the rest repeats timings in turn.
  const double share = (options.study.budget * 2 / 3) / static_cast<double>(contenders.size());
  {
    Progress progress("scoring", "methods", contenders.size(), common.quiet);
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      study.blocks.push_back(
          {contenders[c], rows_of(contenders[c], target, metric, share, options.study.quick)});
      progress.update(c + 1);
    }
  }
  for (int repeat = 0; repeat < 8 && seconds_since(start) < options.study.budget; ++repeat) {
    for (AccuracyBlock& block : study.blocks) {
      for (AccuracyRow& row : block.rows) {
        stop_if_interrupted();
        // The dearest would eat the budget of all others; their spread matters least.
        if (row.cpu.empty() || row.cpu.front() * target.problem.duration() > share / 20) continue;
        if (seconds_since(start) < options.study.budget) add_timing(target.problem, row);
      }
    }
  }

  const std::filesystem::path folder = study_folder(options.study);
  write_csv(points_table(study), folder / "chart");
  const Table reach = reach_table(study);
  write_csv(reach, folder / "chart_reach");
  const Chart chart = accuracy_chart(study);
  write_chart(chart, folder / "chart");
  AtomicFile page(folder / "chart.html");
  page.write(accuracy_page(study, draw_chart(chart, ChartFormat::svg)));
  page.commit();
  write_output(common.json ? accuracy_json(study) : to_text(reach));
  if (!common.quiet) fmt::print(stderr, "{}/chart: .csv .svg .png .html\n", folder.string());
  return kDone;
}

}  // namespace

void add_chart(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "chart", "Speed against accuracy of every method",
                                  R"(  taut chart scenes/rope_swing.toml
  taut chart scenes/rope_swing.toml --quick
  taut chart scenes/rope_swing.toml --methods springs,xpbd,direct --budget 60)");
  const auto options = std::make_shared<Options>();
  add_study_options(command, options->study, 240);
  command.callback([options, &program] {
    program.run = [options, &program] {
      if (options->study.quick) options->study.budget = std::min(options->study.budget, 15.0);
      return run(*options, program.common);
    };
  });
}

}  // namespace taut::cli
