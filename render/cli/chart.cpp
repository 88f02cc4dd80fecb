// taut chart: speed against accuracy.

#include "render/chart/chart.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "render/base/atomic_file.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/program/part.h"
#include "render/study/model_error.h"
#include "render/study/scoring.h"
#include "render/study/study_target.h"

namespace taut::cli {
namespace chart_command {
namespace {

constexpr options::Budgets kBudgets{.usual = 240, .quick = 20};

constexpr const char* kTruth = "truth";  // the row of a part's horizon (s) and self-error (m)
studies::Target solved_target(const options::StudyOptions& options, const scenes::Scene& scene,
                              bool quiet) {
  if (!quiet) program::note("solving the truth\n");
  return studies::scored_target(scene, studies::least_share(options.quick));
}

bool has_model_study(const options::StudyOptions& options, const scenes::Scene& scene) {
  return !options.quick && scene.world.connectors.size() == 1;
}

/// The work that parts share: the runs of all candidates, and those of the model study.
program::Pieces shared_work(const options::StudyOptions& options, const scenes::Scene& scene,
                            const std::vector<MethodChoice>& candidates) {
  program::Pieces pieces{"chart", "runs", program::Share::in_turn, {}};
  for (const MethodChoice& candidate : candidates)
    pieces.keys.push_back(studies::score_key(candidate));
  if (has_model_study(options, scene)) {
    for (std::string& key : studies::model_keys()) pieces.keys.push_back(std::move(key));
  }
  return pieces;
}

int run_part(const options::StudyOptions& options, const scenes::Scene& scene,
             const studies::AccuracyStudy& study, const std::vector<study::Metric>& metrics,
             const program::Common& common) {
  const std::vector<MethodChoice> candidates = studies::all_candidates(study, options.quick);
  std::optional<studies::Target> target;
  const auto work = [&](std::size_t i, program::Journal& journal) {
    if (!target) {
      target = solved_target(options, scene, common.quiet);
      journal.add(kTruth, {program::exact(target->reference.horizon),
                           program::exact(target->reference.self_error)});
    }
    if (i >= candidates.size()) {
      return studies::model_row(options, target->reference.horizon, i - candidates.size());
    }
    return studies::scored_and_timed(
        *target, metrics, candidates[i],
        studies::cap_of_a_run(study, studies::kScoring * options.budget),
        studies::kSlow * options.budget);
  };
  return program::do_part(options.part, shared_work(options, scene, candidates),
                          options::study_folder(options), options::stamp_of(options), common, work);
}

int run(const options::StudyOptions& options, bool markdown, const program::Common& common) {
  const scenes::Scene scene = options::study_scene(options, {}, true);
  studies::AccuracyStudy study = studies::accuracy_study(options, scene);
  const std::vector<study::Metric> metrics = studies::accuracy_metrics(scene);
  if (options.part.is_part()) return run_part(options, scene, study, metrics, common);

  chart::require_gnuplot();
  const std::filesystem::path folder = options::study_folder(options);
  const bool merge = options.part.merge;
  program::Journal journal =
      merge ? program::merged_journal(
                  shared_work(options, scene, studies::all_candidates(study, options.quick)),
                  folder, options::stamp_of(options))
            : program::Journal(folder / "chart.unfinished", options::stamp_of(options));
  if (merge) {
    const auto* truth = journal.find(kTruth);
    if (!truth) throw program::Misuse("--merge: there are no runs to merge");
    study.horizon = program::number_in(truth->at(0));
    study.self_error = program::number_in(truth->at(1)) / studies::scored_length(scene);
    studies::merge_rows(study, metrics, options.quick, journal);
  } else {
    if (!common.quiet && journal.kept() > 0) {
      program::note("going on after {} runs of a chart that was stopped\n", journal.kept());
    }
    const studies::Target target = solved_target(options, scene, common.quiet);
    study.horizon = target.reference.horizon;
    study.self_error = target.reference.self_error / studies::scored_length(scene);
    studies::measure(study, target, metrics, options.budget, options.quick, &journal, common.quiet);
  }
  if (has_model_study(options, scene)) {
    if (!common.quiet && !merge) program::note("solving chains of 6 to 321 particles\n");
    study.model = studies::model_study(options, study.horizon, journal);
  }

  const chart::Table work_precision = studies::work_precision_table(study);
  options::write_csv(studies::points_table(study, true), folder / "chart");
  options::write_csv(work_precision, folder / "chart_work_precision");
  const chart::Chart chart = studies::accuracy_chart(study);
  chart::write_chart(chart, folder / "chart");
  if (!study.model.rows.empty()) {
    options::write_csv(studies::model_table(study.model), folder / "chart_model");
    chart::write_chart(studies::model_chart(study.model, study.title), folder / "chart_model");
  }
  render::AtomicFile page(folder / "chart.html");
  page.write(studies::accuracy_page(study));
  page.commit();
  if (!merge) journal.finish();
  if (common.json) {
    render::write_output(studies::accuracy_json(study));
  } else {
    const chart::Table best = studies::best_table(study);
    render::write_output(
        markdown ? chart::to_markdown(best) + "\n" + chart::to_markdown(work_precision)
                 : program::table_text(best) + "\n" + program::table_text(work_precision));
  }
  if (!common.quiet) program::note("{}/chart: .csv .svg .png .html\n", folder.string());
  return program::kDone;
}

}  // namespace
}  // namespace chart_command

void add_chart(CLI::App& app, program::Program& program) {
  using namespace chart_command;
  program::Command command =
      program::add_command(app, program, "chart", "Speed against accuracy of every method",
                           R"(  taut chart scenes/rope_swing.toml
  taut chart scenes/rope_swing.toml --quick
  taut chart scenes/rope_swing.toml --methods springs,xpbd,direct --budget 60
  taut chart scenes/rope_swing.toml --part 3/100

An interrupted chart resumes when the same command is run again. Parts are separate processes, on
any machines that share the folder of results: each scores and times every N-th run, and --merge
draws the chart from their rows. --budget then only limits the time of one run.)");
  const auto options = std::make_shared<options::StudyOptions>();
  const auto markdown = std::make_shared<bool>(false);
  options::add_study_options(command, *options, kBudgets);
  program::add_part_options(command, options->part, "runs");
  options->features = options::study_features("chart");
  command.add_flag("--markdown", *markdown, "Print the tables as Markdown");
  command.callback([options, markdown, &program] {
    program.run = [options, markdown, &program] {
      options::choose_budget(*options, kBudgets);
      return options::for_each_study(
          *options, program.common,
          [&](const options::StudyOptions& one) { return run(one, *markdown, program.common); });
    };
  });
}

}  // namespace taut::cli
