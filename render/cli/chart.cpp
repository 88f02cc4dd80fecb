// taut chart: speed against accuracy.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "render/atomic_file.h"
#include "render/cli/accuracy_page.h"
#include "render/cli/command.h"
#include "render/cli/journal.h"
#include "render/cli/model_error.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"
#include "render/interrupt.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  // shares of the length
constexpr std::size_t kTimings = 10, kSlowTimings = 3;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<std::string> cells_of(const AccuracyRow& row) {
  std::vector<std::string> cells{std::to_string(static_cast<int>(row.end)),
                                 row.reason,
                                 exact(row.steps),
                                 exact(row.solves),
                                 exact(row.stretch_max),
                                 exact(row.cpu.empty() ? 0 : row.cpu.front())};
  for (const double error : row.errors) cells.push_back(exact(error));
  return cells;
}

AccuracyRow row_from(const Candidate& candidate, const std::vector<std::string>& cells) {
  AccuracyRow row;
  row.candidate = candidate;
  row.end = static_cast<Run::End>(number_in(cells.at(0)));
  row.reason = cells.at(1);
  row.steps = number_in(cells.at(2));
  row.solves = number_in(cells.at(3));
  row.stretch_max = number_in(cells.at(4));
  if (row.end == Run::End::done) row.cpu = {number_in(cells.at(5))};
  for (std::size_t i = 6; i < cells.size(); ++i) row.errors.push_back(number_in(cells[i]));
  return row;
}

AccuracyRow not_run(const Candidate& candidate, std::size_t metrics) {
  AccuracyRow row;
  row.candidate = candidate;
  row.end = Run::End::over_cap;
  row.reason = "the method's share of the budget was spent";
  row.errors.assign(metrics, std::numeric_limits<double>::infinity());
  return row;
}

/// Scores every candidate of every contender, cheap ones first, within equal shares of `seconds`.
void score_all(AccuracyStudy& study, const Target& target, const std::vector<Metric>& metrics,
               double seconds, bool quick, Journal& journal, bool quiet) {
  std::vector<std::vector<Candidate>> candidates;
  std::size_t total = 0;
  for (const AccuracyBlock& block : study.blocks) {
    candidates.push_back(candidates_of(block.contender, quick));
    total += candidates.back().size();
  }
  Progress progress("scoring", "runs", total, quiet);
  std::size_t done = 0;
  const double share = seconds / static_cast<double>(study.blocks.size());
  for (std::size_t b = 0; b < study.blocks.size(); ++b) {
    const Clock::time_point start = Clock::now();
    for (const Candidate& candidate : candidates[b]) {
      stop_if_interrupted();
      const std::string key = "score " + describe(candidate);
      if (const auto* cells = journal.find(key)) {
        study.blocks[b].rows.push_back(row_from(candidate, *cells));
      } else if (seconds_since(start) > share) {
        study.blocks[b].rows.push_back(not_run(candidate, metrics.size()));
      } else {
        const AccuracyRow row =
            score(target.problem, target.reference, metrics, candidate, share / 4);
        journal.add(key, cells_of(row));
        study.blocks[b].rows.push_back(row);
      }
      progress.update(++done);
    }
  }
}

/// True for the rows that are on a front by any metric.
std::vector<bool> on_a_front(const AccuracyBlock& block, std::size_t metrics) {
  std::vector<bool> best(block.rows.size());
  for (std::size_t metric = 0; metric < metrics; ++metric) {
    for (const std::size_t i : pareto_front(cost_and_error(block.rows, metric))) best[i] = true;
  }
  return best;
}

/// Times all once more and the fronts again and again, in turn, until `seconds` are over; those
/// that take more than `slow` seconds less often, for they would eat the time of all others.
void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow) {
  const Clock::time_point start = Clock::now();
  for (std::size_t timings = 1; timings < kTimings; ++timings) {
    for (AccuracyBlock& block : study.blocks) {
      const std::vector<bool> best = on_a_front(block, metrics);
      for (std::size_t i = 0; i < block.rows.size(); ++i) {
        AccuracyRow& row = block.rows[i];
        stop_if_interrupted();
        if (seconds_since(start) > seconds) return;
        if (row.cpu.empty() || (timings > 1 && !best[i])) continue;
        if (timings >= kSlowTimings && row.cpu.front() * target.problem.duration() > slow) continue;
        add_timing(target.problem, row);
      }
    }
  }
}

int run(const StudyOptions& options, bool markdown, const Common& common) {
  const Scene scene = study_scene(options, {}, true);
  const double length = scene.world.connectors.front().length;
  if (!(length > 0)) throw Misuse("a joint has no length to measure errors by");
  const std::filesystem::path folder = study_folder(options);
  Journal journal(folder / "chart.unfinished", stamp_of(options));
  if (!common.quiet && journal.kept() > 0) {
    fmt::print(stderr, "going on after {} runs of a chart that was stopped\n", journal.kept());
  }
  if (!common.quiet) fmt::print(stderr, "solving the truth\n");
  TruthOptions truth;
  truth.scored_error = length * (options.quick ? 1e-4 : 1e-6);
  if (options.quick) truth.second_accuracy = 1e-7;
  const Target target = target_of(scene, scene.duration, truth);
  if (target.problem.times.size() < 2) {
    throw Misuse(fmt::format("{}: nothing is predictable: the horizon of the truth is {} s",
                             options.scene, target.reference.horizon));
  }

  AccuracyStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  study.horizon = target.reference.horizon;
  study.self_error = target.reference.self_error / length;
  study.particles = scene.world.connectors.front().particles();
  study.targets.assign(std::begin(kTargets), std::end(kTargets));
  std::vector<Metric> metrics{share_of_length(length)};
  if (const auto pixels = pixels_of(scene)) metrics.push_back(*pixels);
  study.in_pixels = metrics.size() > 1;
  for (const Contender& contender : chosen_contenders(options)) {
    study.blocks.push_back({contender, {}});
  }
  // Most of the time finds errors, the rest repeats timings.
  score_all(study, target, metrics, 0.6 * options.budget, options.quick, journal, common.quiet);
  time_all(study, target, metrics.size(), 0.4 * options.budget, 0.002 * options.budget);
  std::vector<AccuracyRow> rows;
  for (const AccuracyBlock& block : study.blocks) {
    rows.insert(rows.end(), block.rows.begin(), block.rows.end());
  }
  study.unsteadiness = unsteadiness(rows);
  if (!options.quick && scene.world.connectors.size() == 1) {
    if (!common.quiet) fmt::print(stderr, "solving chains of 6 to 321 particles\n");
    study.model = model_study(options, study.horizon, journal);
  }

  const Table reach = reach_table(study);
  write_csv(points_table(study), folder / "chart");
  write_csv(reach, folder / "chart_reach");
  const Chart chart = accuracy_chart(study);
  write_chart(chart, folder / "chart");
  if (!study.model.rows.empty()) {
    write_csv(model_table(study.model), folder / "chart_model");
    write_chart(model_chart(study.model, study.title), folder / "chart_model");
  }
  AtomicFile page(folder / "chart.html");
  page.write(accuracy_page(study));
  page.commit();
  journal.finish();
  if (common.json) {
    write_output(accuracy_json(study));
  } else {
    const Table best = best_table(study);
    write_output(markdown ? to_markdown(best) + "\n" + to_markdown(reach)
                          : to_text(best) + "\n" + to_text(reach));
  }
  if (!common.quiet) fmt::print(stderr, "{}/chart: .csv .svg .png .html\n", folder.string());
  return kDone;
}

}  // namespace

void add_chart(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "chart", "Speed against accuracy of every method",
                                  R"(  taut chart scenes/rope_swing.toml
  taut chart scenes/rope_swing.toml --quick
  taut chart scenes/rope_swing.toml --methods springs,xpbd,direct --budget 60

A chart that is stopped goes on where it was when the same command is given again.)");
  const auto options = std::make_shared<StudyOptions>();
  const auto markdown = std::make_shared<bool>(false);
  add_study_options(command, *options, 240);
  options->follows = Follows::pins;
  command.add_flag("--markdown", *markdown, "The tables as Markdown");
  command.callback([options, markdown, &program] {
    program.run = [options, markdown, &program] {
      if (options->quick) options->budget = std::min(options->budget, 20.0);
      return run(*options, *markdown, program.common);
    };
  });
}

}  // namespace taut::cli
