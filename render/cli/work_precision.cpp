// taut work-precision: the cost of an error for each method, scene beside scene.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "render/base/atomic_file.h"
#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/json.h"
#include "render/program/note.h"
#include "render/program/terminal.h"
#include "render/study/accuracy_page.h"
#include "render/study/scoring.h"
#include "render/study/study_target.h"
#include "sim/motion/hash.h"

namespace taut::cli {
namespace work_precision_command {
namespace {

struct Options {
  options::StudyOptions study;                   // its scene is each of its inputs in turn
  std::vector<double> errors{1e-2, 1e-3, 1e-4};  // m
  bool markdown = false;
};

using Clock = std::chrono::steady_clock;

double least_error(const Options& options) {
  return *std::ranges::min_element(options.errors);
}

constexpr double kScoring = 0.7, kTiming = 0.3;  // shares of the budget
constexpr double kSlow = 0.002;                  // share of it that is a long run
constexpr double kMetre = 1;

studies::Target solved_target(const options::StudyOptions& options, double least_error,
                              bool quiet) {
  const scenes::Scene scene = options::study_scene(options);
  if (!quiet) program::note("{}: solving the truth\n", options.scene);
  truth::TruthOptions truth;
  truth.scored_error = least_error;
  truth.second_accuracy = (options.quick ? 5e-3 : 1e-4) * least_error;
  return studies::predictable_target(scene, truth);
}

/// Without rows.
studies::AccuracyStudy empty_study(const options::StudyOptions& options) {
  studies::AccuracyStudy study;
  study.scene = options.scene;
  study.title = options::study_scene(options).title;
  for (const options::Contender& contender : options::chosen_contenders(options)) {
    study.blocks.push_back({contender, {}});
  }
  return study;
}

studies::AccuracyStudy study_of(const options::StudyOptions& options, double least_error,
                                bool quiet) {
  const Clock::time_point begin = Clock::now();
  const studies::Target target = solved_target(options, least_error, quiet);
  // The truth is part of the budget, but for what the rest needs at least.
  const double spent = std::chrono::duration<double>(Clock::now() - begin).count();
  const double left = std::max(options.budget - spent, 0.3 * options.budget);
  studies::AccuracyStudy study = empty_study(options);
  studies::score_all(study, target, {study::share_of_length(kMetre)}, kScoring * left,
                     options.quick, nullptr, quiet);
  studies::time_all(study, target, 1, kTiming * left, kSlow * left);
  study.horizon = target.reference.horizon;
  return study;
}

/// The runs of all scenes, for parts to share out: those of a scene beside each other, for they
/// share its truth.
class SharedRuns {
 public:
  explicit SharedRuns(const Options& options) : options_(options) {
    Hash stamp;
    for (const std::string& scene : options.study.inputs.scenes) {
      options::StudyOptions one = options.study;
      one.scene = scene;
      stamp.text(scene).number(options::stamp_of(one));
      const studies::AccuracyStudy study = empty_study(one);
      for (study::Candidate& candidate : studies::all_candidates(study, one.quick)) {
        pieces_.keys.push_back(key_of(scenes_.size(), candidate));
        runs_.push_back({scenes_.size(), std::move(candidate)});
      }
      scenes_.push_back(std::move(one));
      cap_ = studies::cap_of_a_run(study, kScoring * one.budget);
    }
    for (const double error : options.errors) stamp.number(error);
    stamp_ = stamp.value();
  }

  int run_part(const program::Common& common) const {
    const std::vector<study::Metric> metrics{study::share_of_length(kMetre)};
    std::optional<studies::Target> target;
    std::size_t of_target = 0;
    return program::do_part(
        options_.study.part, pieces_, folder(), stamp_, common,
        [&](std::size_t i, program::Journal& journal) {
          const auto& [scene, candidate] = runs_[i];
          if (!target || of_target != scene) {
            target = solved_target(scenes_[scene], least_error(options_), common.quiet);
            of_target = scene;
            journal.add(truth_key(scene), {program::exact(target->reference.horizon)});
          }
          return studies::scored_and_timed(*target, metrics, candidate, cap_,
                                           kSlow * options_.study.budget);
        });
  }

  std::vector<studies::AccuracyStudy> merged() const {
    const program::Journal journal = program::merged_journal(pieces_, folder(), stamp_);
    std::vector<studies::AccuracyStudy> studies;
    for (std::size_t s = 0; s < scenes_.size(); ++s) {
      studies::AccuracyStudy study = empty_study(scenes_[s]);
      for (studies::AccuracyBlock& block : study.blocks) {
        for (const study::Candidate& candidate :
             options::candidates_of(block.contender, options_.study.quick)) {
          block.rows.push_back(studies::row_from(candidate, *journal.find(key_of(s, candidate))));
        }
      }
      if (const auto* truth = journal.find(truth_key(s)))
        study.horizon = program::number_in(truth->at(0));
      studies.push_back(std::move(study));
    }
    return studies;
  }

 private:
  struct SceneRun {
    std::size_t scene = 0;
    study::Candidate candidate;
  };

  static std::string key_of(std::size_t scene, const study::Candidate& candidate) {
    return fmt::format("{} {}", scene, studies::score_key(candidate));
  }
  static std::string truth_key(std::size_t scene) { return fmt::format("{} truth", scene); }
  std::filesystem::path folder() const {
    return options_.study.out.empty() ? "out" : options_.study.out;
  }

  const Options& options_;
  program::Pieces pieces_{"work_precision", "runs", program::Share::neighbours, {}};
  std::vector<options::StudyOptions> scenes_;
  std::vector<SceneRun> runs_;
  double cap_ = 0;  // s
  std::uint64_t stamp_ = 0;
};

/// The cheapest row of every contender that comes within `error` (m).
std::vector<const study::AccuracyRow*> cheapest_rows(const studies::AccuracyStudy& study,
                                                     double error) {
  std::vector<const study::AccuracyRow*> rows;
  for (const studies::AccuracyBlock& block : study.blocks) {
    const auto row = study::cheapest(study::cost_and_error(block.rows, 0), error);
    rows.push_back(row ? &block.rows[*row] : nullptr);
  }
  return rows;
}

double milliseconds(const study::AccuracyRow& row) {
  return 1e3 * study::spread(row.cpu).median;
}

/// A row per contender; a column per scene and error: the cost, and how many times that of the
/// cheapest it is.
chart::Table side_by_side(const std::vector<studies::AccuracyStudy>& studies,
                          const std::vector<double>& errors) {
  chart::Table table{{"ms per simulated second"}, {}};
  std::vector<std::vector<std::string>> rows;
  for (const studies::AccuracyBlock& block : studies.front().blocks)
    rows.push_back({block.contender.label});
  for (const studies::AccuracyStudy& study : studies) {
    for (const double error : errors) {
      table.columns.push_back(fmt::format("{}: {:g} mm", study.title, 1e3 * error));
      const auto best = cheapest_rows(study, error);
      double least = INFINITY;
      for (const study::AccuracyRow* row : best) {
        if (row) least = std::min(least, milliseconds(*row));
      }
      for (std::size_t i = 0; i < best.size(); ++i) {
        const std::string missing(study.blocks[i].contender.method->missing);
        rows[i].push_back(!missing.empty() ? missing
                          : !best[i]
                              ? "-"
                              : fmt::format("{} ({}x)", options::rounded(milliseconds(*best[i])),
                                            options::rounded(milliseconds(*best[i]) / least)));
      }
    }
  }
  for (auto& row : rows) table.add(std::move(row));
  return table;
}

/// The same, a row each, with the settings that do it.
chart::Table details(const std::vector<studies::AccuracyStudy>& studies,
                     const std::vector<double>& errors) {
  chart::Table table{{"scene", "method", "error asked for (m)", "settings", "error (m)",
                      "CPU per simulated second (s)", "low quartile (s)", "high quartile (s)",
                      "timings", "penetration (m)", "energy gained (J)"},
                     {}};
  for (const studies::AccuracyStudy& study : studies) {
    for (const double error : errors) {
      const auto best = cheapest_rows(study, error);
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (!best[i]) continue;
        const study::Spread time = study::spread(best[i]->cpu);
        table.add({study.scene, study.blocks[i].contender.label, fmt::format("{:g}", error),
                   study::describe(best[i]->candidate.settings),
                   fmt::format("{:.3g}", best[i]->errors[0]), fmt::format("{:.4g}", time.median),
                   fmt::format("{:.4g}", time.low), fmt::format("{:.4g}", time.high),
                   std::to_string(best[i]->cpu.size()),
                   fmt::format("{:.2g}", best[i]->penetration_max),
                   fmt::format("{:.2g}", best[i]->energy_gain)});
      }
    }
  }
  return table;
}

/// Why cells are empty: how near the method came, or what ended its runs.
chart::Table empty_cells(const std::vector<studies::AccuracyStudy>& studies,
                         const std::vector<double>& errors) {
  chart::Table table{{"scene", "empty for", "nearest (m)", "settings", "others"}, {}};
  const double least = *std::ranges::min_element(errors);
  for (const studies::AccuracyStudy& study : studies) {
    for (const studies::AccuracyBlock& block : study.blocks) {
      if (block.rows.empty() || study::cheapest(study::cost_and_error(block.rows, 0), least))
        continue;
      const auto nearest =
          std::ranges::min_element(block.rows, {}, [](const study::AccuracyRow& row) {
            return row.end == study::Run::End::done ? row.errors[0] : INFINITY;
          });
      const auto ended = std::ranges::find_if(block.rows, [](const study::AccuracyRow& row) {
        return row.end != study::Run::End::done;
      });
      const bool any = nearest->end == study::Run::End::done;
      table.add({study.scene, block.contender.label,
                 any ? fmt::format("{:.3g}", nearest->errors[0]) : "none",
                 any ? study::describe(nearest->candidate.settings) : "",
                 ended == block.rows.end() ? "" : ended->reason});
    }
  }
  return table;
}

program::Json json_of(const studies::AccuracyStudy& study, const std::vector<double>& errors) {
  program::Json json = {
      {"scene", study.scene}, {"title", study.title}, {"horizon_s", study.horizon}};
  for (const studies::AccuracyBlock& block : study.blocks) {
    program::Json entry = {{"method", block.contender.label}};
    const std::string missing(block.contender.method->missing);
    if (!missing.empty()) entry["missing"] = missing;
    for (const double error : errors) {
      const auto found = study::cheapest(study::cost_and_error(block.rows, 0), error);
      program::Json point = {{"error_asked_m", error}, {"cpu_ms_per_simulated_s", nullptr}};
      if (found) {
        const study::AccuracyRow& row = block.rows[*found];
        const study::Spread time = study::spread(row.cpu);
        point.update({{"cpu_ms_per_simulated_s", 1e3 * time.median},
                      {"low_quartile_ms", 1e3 * time.low},
                      {"high_quartile_ms", 1e3 * time.high},
                      {"timings", row.cpu.size()},
                      {"rms_error_m", row.errors[0]},
                      {"penetration_m", row.penetration_max},
                      {"energy_gained_j", row.energy_gain},
                      {"settings", options::settings_json(row.candidate.settings)}});
      }
      entry["work_precision"].push_back(std::move(point));
    }
    double nearest = INFINITY;
    for (const study::AccuracyRow& row : block.rows)
      if (row.end == study::Run::End::done) nearest = std::min(nearest, row.errors[0]);
    entry["least_rms_error_m"] = program::number_or_null(nearest);
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

int run(Options options, const program::Common& common) {
  std::vector<studies::AccuracyStudy> studies;
  const program::PartOptions& part = options.study.part;
  if (part.is_part()) return SharedRuns(options).run_part(common);
  if (part.merge) studies = SharedRuns(options).merged();
  options::tell_old_keys(options.study.inputs, common);
  for (const std::string& scene : options.study.inputs.scenes) {
    if (part.merge) break;
    options.study.scene = scene;
    studies.push_back(study_of(options.study, least_error(options), common.quiet));
  }
  const chart::Table detail = details(studies, options.errors);
  if (!options.study.out.empty()) {
    options::write_csv(detail, std::filesystem::path(options.study.out) / "work_precision");
  }
  const chart::Table table = side_by_side(studies, options.errors);
  const chart::Table empty = empty_cells(studies, options.errors);
  if (common.json) {
    program::Json json = {{"machine", options::machine()}, {"scenes", program::Json::array()}};
    for (const studies::AccuracyStudy& study : studies)
      json["scenes"].push_back(json_of(study, options.errors));
    render::write_output(json.dump(2) + "\n");
    return program::kDone;
  }
  std::string output;
  for (const chart::Table* one : {&table, &detail, &empty}) {
    if (one->rows.empty()) continue;
    if (!output.empty()) output += "\n";
    output += options.markdown ? chart::to_markdown(*one) : program::table_text(*one);
  }
  render::write_output(output);
  return program::kDone;
}

}  // namespace
}  // namespace work_precision_command

void add_work_precision(CLI::App& app, program::Program& program) {
  using namespace work_precision_command;
  program::Command command = program::add_command(
      app, program, "work-precision", "The cost of an error for each method, scene beside scene",
      R"(  taut work-precision scenes/bench_*.toml
  taut work-precision scenes/bench_*.toml --errors 0.01,0.001,0.0001 --markdown --out out/bench

CPU milliseconds per simulated second of the cheapest settings whose RMS position error over the
scene's duration, as far as its truth is predictable, is at most so many metres; in brackets, how
many times the cheapest of all that is. Runs are timed in turn; medians. Parts (--part 3/100) are
processes of their own, on any machines that share the folder of --out: each takes neighbouring runs
and times them one after another; --merge makes the tables.)");
  const auto options = std::make_shared<Options>();
  options->study.budget = 120;
  options->study.among_obstacles = true;
  options::add_scene_options(command, options->study.inputs);
  command.add_option("--errors", options->errors, "m, with commas; default: 0.01,0.001,0.0001")
      .delimiter(',')
      .positive();
  command.add_option("--out", options->study.out, "Folder for work_precision.csv; default: none");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, with commas; default: all")
      .delimiter(',');
  command
      .add_option("--budget", options->study.budget,
                  "Seconds that each scene may take, about; default: 120")
      .positive();
  command.add_flag("--quick", options->study.quick, "Few settings of each method");
  program::add_part_options(command, options->study.part, "runs");
  command.add_flag("--markdown", options->markdown, "The tables as Markdown");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
