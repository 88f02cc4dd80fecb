// taut chart: speed against accuracy.

#include <algorithm>
#include <memory>
#include <optional>

#include "render/atomic_file.h"
#include "render/chart/gnuplot.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/journal.h"
#include "render/program/note.h"
#include "render/program/terminal.h"
#include "render/study/accuracy_page.h"
#include "render/study/accuracy_study.h"
#include "render/study/model_error.h"
#include "render/study/scoring.h"
#include "render/study/study_target.h"

namespace taut::cli {
namespace {

constexpr const char* kTruth = "truth";  // the row of a part's horizon (s) and self-error (m)
Target solved_target(const StudyOptions& options, const Scene& scene, bool quiet) {
  if (!quiet) note("solving the truth\n");
  return scored_target(scene, least_share(options.quick));
}

bool has_model_study(const StudyOptions& options, const Scene& scene) {
  return !options.quick && scene.world.connectors.size() == 1;
}

/// What parts share out: the runs of all candidates, and those of the model study.
Pieces shared_work(const StudyOptions& options, const Scene& scene,
                   const std::vector<Candidate>& candidates) {
  Pieces pieces{"chart", "runs", Share::in_turn, {}};
  for (const Candidate& candidate : candidates) pieces.keys.push_back(score_key(candidate));
  if (has_model_study(options, scene)) {
    for (std::string& key : model_keys()) pieces.keys.push_back(std::move(key));
  }
  return pieces;
}

int run_part(const StudyOptions& options, const Scene& scene, const AccuracyStudy& study,
             const std::vector<Metric>& metrics, const Common& common) {
  const std::vector<Candidate> candidates = all_candidates(study, options.quick);
  std::optional<Target> target;
  const auto work = [&](std::size_t i, Journal& journal) {
    if (!target) {
      target = solved_target(options, scene, common.quiet);
      journal.add(kTruth, {exact(target->reference.horizon), exact(target->reference.self_error)});
    }
    if (i >= candidates.size()) {
      return model_row(options, target->reference.horizon, i - candidates.size());
    }
    return scored_and_timed(*target, metrics, candidates[i],
                            cap_of_a_run(study, kScoring * options.budget), kSlow * options.budget);
  };
  return do_part(options.part, shared_work(options, scene, candidates), study_folder(options),
                 stamp_of(options), common, work);
}

int run(const StudyOptions& options, bool markdown, const Common& common) {
  const Scene scene = study_scene(options, {}, true);
  AccuracyStudy study = accuracy_study(options, scene);
  const std::vector<Metric> metrics = accuracy_metrics(scene);
  if (options.part.is_part()) return run_part(options, scene, study, metrics, common);

  require_gnuplot();
  const std::filesystem::path folder = study_folder(options);
  const bool merge = options.part.merge;
  Journal journal =
      merge ? merged_journal(shared_work(options, scene, all_candidates(study, options.quick)),
                             folder, stamp_of(options))
            : Journal(folder / "chart.unfinished", stamp_of(options));
  if (merge) {
    const auto* truth = journal.find(kTruth);
    if (!truth) throw Misuse("--merge: there are no runs to merge");
    study.horizon = number_in(truth->at(0));
    study.self_error = number_in(truth->at(1)) / scored_length(scene);
    merge_rows(study, metrics, options.quick, journal);
  } else {
    if (!common.quiet && journal.kept() > 0) {
      note("going on after {} runs of a chart that was stopped\n", journal.kept());
    }
    const Target target = solved_target(options, scene, common.quiet);
    study.horizon = target.reference.horizon;
    study.self_error = target.reference.self_error / scored_length(scene);
    measure(study, target, metrics, options.budget, options.quick, &journal, common.quiet);
  }
  if (has_model_study(options, scene)) {
    if (!common.quiet && !merge) note("solving chains of 6 to 321 particles\n");
    study.model = model_study(options, study.horizon, journal);
  }

  const Table reach = reach_table(study);
  write_csv(points_table(study, true), folder / "chart");
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
  if (!merge) journal.finish();
  if (common.json) {
    write_output(accuracy_json(study));
  } else {
    const Table best = best_table(study);
    write_output(markdown ? to_markdown(best) + "\n" + to_markdown(reach)
                          : table_text(best) + "\n" + table_text(reach));
  }
  if (!common.quiet) note("{}/chart: .csv .svg .png .html\n", folder.string());
  return kDone;
}

}  // namespace

void add_chart(CLI::App& app, Program& program) {
  Command command = add_command(app, program, "chart", "Speed against accuracy of every method",
                                R"(  taut chart scenes/rope_swing.toml
  taut chart scenes/rope_swing.toml --quick
  taut chart scenes/rope_swing.toml --methods springs,xpbd,direct --budget 60
  taut chart scenes/rope_swing.toml --part 3/100

A chart that is stopped goes on where it was when the same command is given again. Parts are
processes of their own, on any machines that share the folder of results: each takes every N-th run,
scores and times it, and --merge draws the chart from their rows. --budget then only sets how long
one run may take.)");
  const auto options = std::make_shared<StudyOptions>();
  const auto markdown = std::make_shared<bool>(false);
  add_study_options(command, *options, 240);
  add_part_options(command, options->part, "runs");
  options->follows = Follows::pins;
  options->among_obstacles = true;
  command.add_flag("--markdown", *markdown, "The tables as Markdown");
  command.callback([options, markdown, &program] {
    program.run = [options, markdown, &program] {
      if (options->quick) options->budget = std::min(options->budget, 20.0);
      return for_each_study(*options, program.common, [&](const StudyOptions& one) {
        return run(one, *markdown, program.common);
      });
    };
  });
}

}  // namespace taut::cli
