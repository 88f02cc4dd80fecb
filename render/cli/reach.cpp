// taut reach: what an error costs each method, scene beside scene.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "render/atomic_file.h"
#include "render/cli/accuracy_page.h"
#include "render/cli/command.h"
#include "render/cli/note.h"
#include "render/cli/scoring.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"

namespace taut::cli {
namespace {

struct Options {
  StudyOptions study;  // its scene is each of `scenes` in turn
  std::vector<std::string> scenes;
  std::vector<double> errors{1e-2, 1e-3, 1e-4};  // m
  bool markdown = false;
};

AccuracyStudy study_of(const StudyOptions& options, double least_error, bool quiet) {
  const Scene scene = study_scene(options);
  if (!quiet) note("{}: solving the truth\n", options.scene);
  TruthOptions truth;
  truth.scored_error = least_error;
  truth.second_accuracy = 1e-4 * least_error;
  const Target target = predictable_target(scene, truth);
  AccuracyStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  for (const Contender& contender : chosen_contenders(options)) {
    study.blocks.push_back({contender, {}});
  }
  constexpr double kMetre = 1;
  score_all(study, target, {share_of_length(kMetre)}, 0.7 * options.budget, options.quick, nullptr,
            quiet);
  time_all(study, target, 1, 0.3 * options.budget, 0.002 * options.budget);
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

int run(Options options, const Common& common) {
  std::vector<AccuracyStudy> studies;
  const double least = *std::ranges::min_element(options.errors);
  for (const std::string& scene : options.scenes) {
    options.study.scene = scene;
    studies.push_back(study_of(options.study, least, common.quiet));
  }
  const Table detail = details(studies, options.errors);
  if (!options.study.out.empty()) {
    write_csv(detail, std::filesystem::path(options.study.out) / "reach");
  }
  const Table table = side_by_side(studies, options.errors);
  const Table empty = empty_cells(studies, options.errors);
  std::string output;
  for (const Table* part : {&table, &detail, &empty}) {
    if (part->rows.empty()) continue;
    if (!output.empty()) output += "\n";
    output += options.markdown ? to_markdown(*part) : to_text(*part);
  }
  write_output(output);
  return kDone;
}

}  // namespace

void add_reach(CLI::App& app, Program& program) {
  CLI::App& command =
      add_command(app, program, "reach", "What an error costs each method, scene beside scene",
                  R"(  taut reach scenes/bench_*.toml
  taut reach scenes/bench_*.toml --errors 0.01,0.001,0.0001 --markdown --out out/reach

CPU milliseconds per simulated second of the cheapest settings whose RMS position error over the
scene's duration, as far as its truth is predictable, is at most so many metres; in brackets, how
many times the cheapest of all that is. Runs are timed in turn; medians.)");
  const auto options = std::make_shared<Options>();
  options->study.budget = 120;
  command.add_option("scenes", options->scenes, "Scene files")->required();
  command.add_option("--errors", options->errors, "m, with commas; default: 0.01,0.001,0.0001")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  command.add_option("--out", options->study.out, "Folder for reach.csv; default: none");
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
