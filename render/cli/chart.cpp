// taut chart: speed against accuracy.

#include <algorithm>
#include <memory>

#include "render/atomic_file.h"
#include "render/cli/accuracy_page.h"
#include "render/cli/command.h"
#include "render/cli/journal.h"
#include "render/cli/model_error.h"
#include "render/cli/note.h"
#include "render/cli/scoring.h"
#include "render/cli/study_options.h"
#include "render/cli/study_target.h"
#include "render/cli/terminal.h"
#include "render/gnuplot.h"

namespace taut::cli {
namespace {

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  // shares of the length

int run(const StudyOptions& options, bool markdown, const Common& common) {
  const Scene scene = study_scene(options, {}, true);
  const double length = scene.world.connectors.front().length;
  if (!(length > 0)) throw Misuse("a joint has no length to measure errors by");
  require_gnuplot();
  const std::filesystem::path folder = study_folder(options);
  Journal journal(folder / "chart.unfinished", stamp_of(options));
  if (!common.quiet && journal.kept() > 0) {
    note("going on after {} runs of a chart that was stopped\n", journal.kept());
  }
  if (!common.quiet) note("solving the truth\n");
  TruthOptions truth;
  truth.scored_error = length * (options.quick ? 1e-4 : 1e-6);
  if (options.quick) truth.second_accuracy = 1e-7;
  const Target target = predictable_target(scene, truth);

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
  score_all(study, target, metrics, 0.6 * options.budget, options.quick, &journal, common.quiet);
  time_all(study, target, metrics.size(), 0.4 * options.budget, 0.002 * options.budget);
  std::vector<AccuracyRow> rows;
  for (const AccuracyBlock& block : study.blocks) {
    rows.insert(rows.end(), block.rows.begin(), block.rows.end());
  }
  study.unsteadiness = unsteadiness(rows);
  if (!options.quick && scene.world.connectors.size() == 1) {
    if (!common.quiet) note("solving chains of 6 to 321 particles\n");
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
                          : table_text(best) + "\n" + table_text(reach));
  }
  if (!common.quiet) note("{}/chart: .csv .svg .png .html\n", folder.string());
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
      return for_each_study(*options, program.common, [&](const StudyOptions& one) {
        return run(one, *markdown, program.common);
      });
    };
  });
}

}  // namespace taut::cli
