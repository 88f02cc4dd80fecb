// taut work-precision: the cost of an error for each method, scene beside scene.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>

#include "render/atomic_file.h"
#include "render/cli/accuracy_page.h"
#include "render/cli/command.h"
#include "render/cli/json.h"
#include "render/cli/method_options.h"
#include "render/cli/note.h"
#include "render/cli/scoring.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"
#include "render/cli/terminal.h"

namespace taut::cli {
namespace {

struct Options {
  StudyOptions study;                            // its scene is each of its inputs in turn
  std::vector<double> errors{1e-2, 1e-3, 1e-4};  // m
  bool markdown = false;
};

using Clock = std::chrono::steady_clock;

AccuracyStudy study_of(const StudyOptions& options, double least_error, bool quiet) {
  const Scene scene = study_scene(options);
  if (!quiet) note("{}: solving the truth\n", options.scene);
  const Clock::time_point begin = Clock::now();
  TruthOptions truth;
  truth.scored_error = least_error;
  truth.second_accuracy = (options.quick ? 5e-3 : 1e-4) * least_error;
  const Target target = predictable_target(scene, truth);
  // The truth is part of the budget, but for what the rest needs at least.
  const double spent = std::chrono::duration<double>(Clock::now() - begin).count();
  const double left = std::max(options.budget - spent, 0.3 * options.budget);
  AccuracyStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  for (const Contender& contender : chosen_contenders(options)) {
    study.blocks.push_back({contender, {}});
  }
  constexpr double kMetre = 1;
  score_all(study, target, {share_of_length(kMetre)}, 0.7 * left, options.quick, nullptr, quiet);
  time_all(study, target, 1, 0.3 * left, 0.002 * left);
  study.horizon = target.reference.horizon;
  return study;
}

/// The cheapest row of every contender that comes within `error` (m).
std::vector<const AccuracyRow*> cheapest_rows(const AccuracyStudy& study, double error) {
  std::vector<const AccuracyRow*> rows;
  for (const AccuracyBlock& block : study.blocks) {
    const auto row = cheapest(cost_and_error(block.rows, 0), error);
    rows.push_back(row ? &block.rows[*row] : nullptr);
  }
  return rows;
}

double milliseconds(const AccuracyRow& row) {
  return 1e3 * spread(row.cpu).median;
}

/// A row per contender; a column per scene and error: the cost, and how many times that of the
/// cheapest it is.
Table side_by_side(const std::vector<AccuracyStudy>& studies, const std::vector<double>& errors) {
  Table table{{"ms per simulated second"}, {}};
  std::vector<std::vector<std::string>> rows;
  for (const AccuracyBlock& block : studies.front().blocks) rows.push_back({block.contender.label});
  for (const AccuracyStudy& study : studies) {
    for (const double error : errors) {
      table.columns.push_back(fmt::format("{}: {:g} mm", study.title, 1e3 * error));
      const auto best = cheapest_rows(study, error);
      double least = INFINITY;
      for (const AccuracyRow* row : best) {
        if (row) least = std::min(least, milliseconds(*row));
      }
      for (std::size_t i = 0; i < best.size(); ++i) {
        const std::string missing(study.blocks[i].contender.method->missing);
        rows[i].push_back(!missing.empty() ? missing
                          : !best[i]       ? "-"
                                     : fmt::format("{} ({}x)", rounded(milliseconds(*best[i])),
                                                   rounded(milliseconds(*best[i]) / least)));
      }
    }
  }
  for (auto& row : rows) table.add(std::move(row));
  return table;
}

/// The same, a row each, with the settings that do it.
Table details(const std::vector<AccuracyStudy>& studies, const std::vector<double>& errors) {
  Table table{{"scene", "method", "error asked for (m)", "settings", "error (m)",
               "CPU per simulated second (s)", "low quartile (s)", "high quartile (s)", "timings"},
              {}};
  for (const AccuracyStudy& study : studies) {
    for (const double error : errors) {
      const auto best = cheapest_rows(study, error);
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (!best[i]) continue;
        const Spread time = spread(best[i]->cpu);
        table.add({study.scene, study.blocks[i].contender.label, fmt::format("{:g}", error),
                   describe(best[i]->candidate.settings), fmt::format("{:.3g}", best[i]->errors[0]),
                   fmt::format("{:.4g}", time.median), fmt::format("{:.4g}", time.low),
                   fmt::format("{:.4g}", time.high), std::to_string(best[i]->cpu.size())});
      }
    }
  }
  return table;
}

/// Why cells are empty: how near the method came, or what ended its runs.
Table empty_cells(const std::vector<AccuracyStudy>& studies, const std::vector<double>& errors) {
  Table table{{"scene", "empty for", "nearest (m)", "settings", "others"}, {}};
  const double least = *std::ranges::min_element(errors);
  for (const AccuracyStudy& study : studies) {
    for (const AccuracyBlock& block : study.blocks) {
      if (block.rows.empty() || cheapest(cost_and_error(block.rows, 0), least)) continue;
      const auto nearest = std::ranges::min_element(block.rows, {}, [](const AccuracyRow& row) {
        return row.end == Run::End::done ? row.errors[0] : INFINITY;
      });
      const auto ended = std::ranges::find_if(
          block.rows, [](const AccuracyRow& row) { return row.end != Run::End::done; });
      const bool any = nearest->end == Run::End::done;
      table.add({study.scene, block.contender.label,
                 any ? fmt::format("{:.3g}", nearest->errors[0]) : "none",
                 any ? describe(nearest->candidate.settings) : "",
                 ended == block.rows.end() ? "" : ended->reason});
    }
  }
  return table;
}

Json json_of(const AccuracyStudy& study, const std::vector<double>& errors) {
  Json json = {{"scene", study.scene}, {"title", study.title}, {"horizon_s", study.horizon}};
  for (const AccuracyBlock& block : study.blocks) {
    Json entry = {{"method", block.contender.label}};
    const std::string missing(block.contender.method->missing);
    if (!missing.empty()) entry["missing"] = missing;
    for (const double error : errors) {
      const auto found = cheapest(cost_and_error(block.rows, 0), error);
      Json reach = {{"error_asked_m", error}, {"cpu_ms_per_simulated_s", nullptr}};
      if (found) {
        const AccuracyRow& row = block.rows[*found];
        const Spread time = spread(row.cpu);
        reach.update({{"cpu_ms_per_simulated_s", 1e3 * time.median},
                      {"low_quartile_ms", 1e3 * time.low},
                      {"high_quartile_ms", 1e3 * time.high},
                      {"timings", row.cpu.size()},
                      {"rms_error_m", row.errors[0]},
                      {"settings", settings_json(row.candidate.settings)}});
      }
      entry["reach"].push_back(std::move(reach));
    }
    double nearest = INFINITY;
    for (const AccuracyRow& row : block.rows)
      if (row.end == Run::End::done) nearest = std::min(nearest, row.errors[0]);
    entry["least_rms_error_m"] = number_or_null(nearest);
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

int run(Options options, const Common& common) {
  std::vector<AccuracyStudy> studies;
  const double least = *std::ranges::min_element(options.errors);
  for (const std::string& scene : options.study.inputs.scenes) {
    options.study.scene = scene;
    studies.push_back(study_of(options.study, least, common.quiet));
  }
  const Table detail = details(studies, options.errors);
  if (!options.study.out.empty()) {
    write_csv(detail, std::filesystem::path(options.study.out) / "work_precision");
  }
  const Table table = side_by_side(studies, options.errors);
  const Table empty = empty_cells(studies, options.errors);
  if (common.json) {
    Json json = {{"machine", machine()}, {"scenes", Json::array()}};
    for (const AccuracyStudy& study : studies)
      json["scenes"].push_back(json_of(study, options.errors));
    write_output(json.dump(2) + "\n");
    return kDone;
  }
  std::string output;
  for (const Table* part : {&table, &detail, &empty}) {
    if (part->rows.empty()) continue;
    if (!output.empty()) output += "\n";
    output += options.markdown ? to_markdown(*part) : table_text(*part);
  }
  write_output(output);
  return kDone;
}

}  // namespace

void add_work_precision(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "work-precision",
                                  "The cost of an error for each method, scene beside scene",
                                  R"(  taut work-precision scenes/bench_*.toml
  taut work-precision scenes/bench_*.toml --errors 0.01,0.001,0.0001 --markdown --out out/bench

CPU milliseconds per simulated second of the cheapest settings whose RMS position error over the
scene's duration, as far as its truth is predictable, is at most so many metres; in brackets, how
many times the cheapest of all that is. Runs are timed in turn; medians.)");
  const auto options = std::make_shared<Options>();
  options->study.budget = 120;
  add_scene_options(command, options->study.inputs);
  command.add_option("--errors", options->errors, "m, with commas; default: 0.01,0.001,0.0001")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  command.add_option("--out", options->study.out, "Folder for work_precision.csv; default: none");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, with commas; default: all")
      ->delimiter(',');
  command
      .add_option("--budget", options->study.budget,
                  "Seconds that each scene may take, about; default: 120")
      ->check(CLI::PositiveNumber);
  command.add_flag("--quick", options->study.quick, "Few settings of each method");
  command.add_flag("--markdown", options->markdown, "The tables as Markdown");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
