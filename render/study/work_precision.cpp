#include "render/study/work_precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "render/base/child.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/scoring.h"
#include "render/study/study_target.h"
#include "sim/motion/hash.h"

namespace taut::studies {
namespace {

constexpr double kScoringShare = 0.7, kTimingShare = 0.3;  // of the budget
constexpr double kSlowShare = 0.002;                       // share of it that is a long run
constexpr double kMetre = 1;

Target solved_target(const options::StudyOptions& options, double least_error, bool quiet) {
  const scenes::Scene scene = options::study_scene(options);
  if (options.reference_step > 0) {
    return stepped_target(scene, options.reference_step, least_error);
  }
  if (!quiet) program::note("{}: solving the truth\n", options.scene);
  truth::TruthOptions truth;
  truth.scored_error = least_error;
  truth.second_accuracy = (options.quick ? 5e-3 : 1e-4) * least_error;
  return predictable_target(scene, truth);
}

/// Without rows.
AccuracyStudy empty_study(const options::StudyOptions& options) {
  AccuracyStudy study;
  study.scene = options.scene;
  study.title = options::study_scene(options).title;
  for (const options::Contender& contender : options::chosen_contenders(options)) {
    study.blocks.push_back({contender, {}});
  }
  return study;
}

AccuracyStudy study_of(const options::StudyOptions& options, double least_error, bool quiet) {
  const double begin = render::process_seconds();
  const Target target = solved_target(options, least_error, quiet);
  // The truth is part of the budget, but for what the rest needs at least.
  const double spent = render::process_seconds() - begin;
  const double left = std::max(options.budget - spent, 0.3 * options.budget);
  AccuracyStudy study = empty_study(options);
  score_all(study, target, {study::share_of_length(kMetre)}, kScoringShare * left, options.quick,
            nullptr, quiet);
  time_all(study, target, 1, kTimingShare * left, kSlowShare * left);
  study.horizon = target.reference.horizon;
  study.self_error = target.reference.self_error;
  return study;
}

/// The runs of all scenes, for parts to share out: those of a scene beside each other, for they
/// share its truth.
class SharedRuns {
 public:
  SharedRuns(const options::StudyOptions& options, const std::vector<double>& errors)
      : options_(options), least_error_(*std::ranges::min_element(errors)) {
    Hash stamp;
    for (const std::string& scene : options.inputs.scenes) {
      options::StudyOptions one = options;
      one.scene = scene;
      stamp.text(scene).number(options::stamp_of(one));
      const AccuracyStudy study = empty_study(one);
      for (MethodChoice& candidate : all_candidates(study, one.quick)) {
        pieces_.keys.push_back(key_of(scenes_.size(), candidate));
        runs_.push_back({scenes_.size(), std::move(candidate)});
      }
      scenes_.push_back(std::move(one));
      cap_ = cap_of_a_run(study, kScoringShare * one.budget);
    }
    for (const double error : errors) stamp.number(error);
    stamp_ = stamp.value();
  }

  int run_part(const program::Common& common) const {
    const std::vector<study::Metric> metrics{study::share_of_length(kMetre)};
    std::optional<Target> target;
    std::size_t of_target = 0;
    return program::do_part(
        options_.part, pieces_, folder(), stamp_, common,
        [&](std::size_t i, program::Journal& journal) {
          const auto& [scene, candidate] = runs_[i];
          if (!target || of_target != scene) {
            target = solved_target(scenes_[scene], least_error_, common.quiet);
            of_target = scene;
            journal.add(truth_key(scene), {program::exact(target->reference.horizon),
                                           program::exact(target->reference.self_error)});
          }
          return scored_and_timed(*target, metrics, candidate, cap_, kSlowShare * options_.budget);
        });
  }

  std::vector<AccuracyStudy> merged() const {
    const program::Journal journal = program::merged_journal(pieces_, folder(), stamp_);
    std::vector<AccuracyStudy> studies;
    for (std::size_t s = 0; s < scenes_.size(); ++s) {
      AccuracyStudy study = empty_study(scenes_[s]);
      for (AccuracyBlock& block : study.blocks) {
        for (const MethodChoice& candidate :
             options::candidates_of(block.contender, options_.quick)) {
          block.rows.push_back(row_from(candidate, *journal.find(key_of(s, candidate))));
        }
      }
      if (const auto* truth = journal.find(truth_key(s))) {
        study.horizon = program::number_in(truth->at(0));
        study.self_error = program::number_in(truth->at(1));
      }
      studies.push_back(std::move(study));
    }
    return studies;
  }

 private:
  struct SceneRun {
    std::size_t scene = 0;
    MethodChoice candidate;
  };

  static std::string key_of(std::size_t scene, const MethodChoice& candidate) {
    return fmt::format("{} {}", scene, score_key(candidate));
  }
  static std::string truth_key(std::size_t scene) { return fmt::format("{} truth", scene); }
  std::filesystem::path folder() const { return options_.out.empty() ? "out" : options_.out; }

  const options::StudyOptions& options_;
  double least_error_;  // m
  program::Pieces pieces_{"work_precision", "runs", program::Share::neighbours, {}};
  std::vector<options::StudyOptions> scenes_;
  std::vector<SceneRun> runs_;
  double cap_ = 0;  // s
  std::uint64_t stamp_ = 0;
};

}  // namespace

std::vector<AccuracyStudy> work_precision(options::StudyOptions options,
                                          const std::vector<double>& errors, bool quiet) {
  std::vector<AccuracyStudy> studies;
  for (const std::string& scene : options.inputs.scenes) {
    options.scene = scene;
    studies.push_back(study_of(options, *std::ranges::min_element(errors), quiet));
  }
  return studies;
}

int work_precision_part(const options::StudyOptions& options, const std::vector<double>& errors,
                        const program::Common& common) {
  return SharedRuns(options, errors).run_part(common);
}

std::vector<AccuracyStudy> merged_work_precision(const options::StudyOptions& options,
                                                 const std::vector<double>& errors) {
  return SharedRuns(options, errors).merged();
}

namespace {

/// The cheapest row of every contender that comes within `error` (m).
std::vector<const study::AccuracyRow*> cheapest_rows(const AccuracyStudy& study, double error) {
  std::vector<const study::AccuracyRow*> rows;
  for (const AccuracyBlock& block : study.blocks) {
    const auto row = study::cheapest(study::cost_and_error(block.rows, 0), error);
    rows.push_back(row ? &block.rows[*row] : nullptr);
  }
  return rows;
}

double milliseconds(const study::AccuracyRow& row) {
  return 1e3 * study::spread(row.cpu).median;
}

/// The row that comes nearest to the truth; null where none is done.
const study::AccuracyRow* nearest_row(const AccuracyBlock& block) {
  const study::AccuracyRow* nearest = nullptr;
  for (const study::AccuracyRow& row : block.rows) {
    if (row.end != study::Run::End::done) continue;
    if (!nearest || row.errors[0] < nearest->errors[0]) nearest = &row;
  }
  return nearest;
}

program::Json row_json(const study::AccuracyRow& row) {
  const study::Spread time = study::spread(row.cpu);
  return {{"cpu_ms_per_simulated_s", 1e3 * time.median},
          {"low_quartile_ms", 1e3 * time.low},
          {"high_quartile_ms", 1e3 * time.high},
          {"timings", row.cpu.size()},
          {"rms_error_m", row.errors[0]},
          {"penetration_m", row.penetration_max},
          {"energy_gained_j", row.energy_gain},
          {"settings", options::settings_json(row.candidate.settings)}};
}

}  // namespace

chart::Table costs_of_errors(const std::vector<AccuracyStudy>& studies,
                             const std::vector<double>& errors) {
  chart::Table table{{"ms per simulated second"}, {}};
  std::vector<std::vector<std::string>> rows;
  for (const AccuracyBlock& block : studies.front().blocks) rows.push_back({block.contender.label});
  for (const AccuracyStudy& study : studies) {
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

chart::Table cheapest_settings(const std::vector<AccuracyStudy>& studies,
                               const std::vector<double>& errors) {
  chart::Table table{{"scene", "method", "error asked for (m)", "settings", "error (m)",
                      "CPU per simulated second (s)", "low quartile (s)", "high quartile (s)",
                      "timings", "penetration (m)", "energy gained (J)"},
                     {}};
  for (const AccuracyStudy& study : studies) {
    for (const double error : errors) {
      const auto best = cheapest_rows(study, error);
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (!best[i]) continue;
        const study::Spread time = study::spread(best[i]->cpu);
        table.add({study.scene, study.blocks[i].contender.label, fmt::format("{:g}", error),
                   describe(best[i]->candidate.settings), fmt::format("{:.3g}", best[i]->errors[0]),
                   fmt::format("{:.4g}", time.median), fmt::format("{:.4g}", time.low),
                   fmt::format("{:.4g}", time.high), std::to_string(best[i]->cpu.size()),
                   fmt::format("{:.2g}", best[i]->penetration_max),
                   fmt::format("{:.2g}", best[i]->energy_gain)});
      }
    }
  }
  return table;
}

chart::Table errors_not_attained(const std::vector<AccuracyStudy>& studies,
                                 const std::vector<double>& errors) {
  chart::Table table{{"scene", "empty for", "nearest (m)", "settings", "others"}, {}};
  const double least = *std::ranges::min_element(errors);
  for (const AccuracyStudy& study : studies) {
    for (const AccuracyBlock& block : study.blocks) {
      if (block.rows.empty() || study::cheapest(study::cost_and_error(block.rows, 0), least))
        continue;
      const study::AccuracyRow* nearest = nearest_row(block);
      const auto ended = std::ranges::find_if(block.rows, [](const study::AccuracyRow& row) {
        return row.end != study::Run::End::done;
      });
      table.add({study.scene, block.contender.label,
                 nearest ? fmt::format("{:.3g}", nearest->errors[0]) : "none",
                 nearest ? describe(nearest->candidate.settings) : "",
                 ended == block.rows.end() ? "" : ended->reason});
    }
  }
  return table;
}

program::Json work_precision_json(const AccuracyStudy& study, const std::vector<double>& errors) {
  program::Json json = {{"scene", study.scene},
                        {"title", study.title},
                        {"horizon_s", study.horizon},
                        {"self_error_m", study.self_error}};
  for (const AccuracyBlock& block : study.blocks) {
    program::Json entry = {{"method", block.contender.label}};
    const std::string missing(block.contender.method->missing);
    if (!missing.empty()) entry["missing"] = missing;
    for (const double error : errors) {
      const auto found = study::cheapest(study::cost_and_error(block.rows, 0), error);
      program::Json point = {{"error_asked_m", error}, {"cpu_ms_per_simulated_s", nullptr}};
      if (found) point.update(row_json(block.rows[*found]));
      entry["work_precision"].push_back(std::move(point));
    }
    const study::AccuracyRow* nearest = nearest_row(block);
    entry["least_rms_error_m"] = program::number_or_null(nearest ? nearest->errors[0] : INFINITY);
    if (nearest) entry["nearest"] = row_json(*nearest);
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace taut::studies
