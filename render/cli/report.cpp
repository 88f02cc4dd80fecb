// taut report: everything that is measured of scenes, as one page.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/base/interrupt.h"
#include "render/film/video.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/report/report_page.h"
#include "render/study/scoring.h"
#include "render/study/stability_study.h"

namespace taut::cli {
namespace report_command {
namespace {

constexpr options::Budgets kBudgets{.usual = 300, .quick = 30};

// Shares of the budget; clips take what they take.
constexpr double kAccuracy = 0.5, kStability = 0.5;
// The share of a page's bytes that clips may take, as base64 of 4 characters for 3 bytes.
constexpr double kForClips = 0.7;

/// Errors over time of every method at its own settings.
std::vector<report::ReportErrors> errors_of(const studies::AccuracyStudy& study,
                                            const studies::Target& target, double length,
                                            double cap) {
  std::vector<report::ReportErrors> all;
  for (const studies::AccuracyBlock& block : study.blocks) {
    render::stop_if_interrupted();
    const options::Contender& one = block.contender;
    if (!one.candidate.settings.empty() || !one.method->missing.empty()) continue;
    const study::Run run = study::run(target.problem, one.candidate, cap);
    all.push_back({one, report::errors_over_time(run, target.reference, length)});
  }
  return all;
}

/// One scene, with the journals of what is not written yet.
struct Measured {
  report::SceneReport report;
  std::vector<program::Journal> journals;
};

void measure_scene(const options::StudyOptions& options, std::size_t most,
                   const program::Common& common, Measured& measured) {
  const scenes::Scene scene = options::study_scene(options, {}, true);
  const std::filesystem::path folder =
      options::results_folder(options.scene, options.out, true) / "report";
  report::SceneReport& report = measured.report;
  if (!common.quiet) program::note("{}: solving the truth\n", options.scene);
  report.accuracy = studies::accuracy_study(options, scene);
  studies::AccuracyStudy& study = report.accuracy;
  const studies::Target target = studies::scored_target(scene, study.share);
  study.horizon = target.reference.horizon;
  study.self_error = target.reference.self_error / studies::scored_length(scene);
  measured.journals.emplace_back(folder / "chart.unfinished", options::stamp_of(options));
  studies::measure(study, target, studies::accuracy_metrics(scene), kAccuracy * options.budget,
                   options.quick, &measured.journals.back(), common.quiet);
  report.errors = errors_of(study, target, studies::scored_length(scene), options.budget / 20);
  report.stability = studies::stability_study(options, scene);
  if (scene.timeline.pins.empty()) {
    options::StudyOptions maps = options;
    maps.budget *= kStability;
    report.stability = studies::stability_study(maps, scene);
    measured.journals.push_back(studies::map_all(report.stability, maps, scene, folder,
                                                 "stability.unfinished", common, {}));
  }
  report.picture = report::report_picture(options, folder, common);
  report.clips = report::report_clips(options, report.stability.contenders, folder, most, common);
}

program::Json json_of(const report::SceneReport& report) {
  std::size_t runs = 0, cells = 0, clips = 0;
  for (const studies::AccuracyBlock& block : report.accuracy.blocks) runs += block.rows.size();
  for (const studies::StabilityMap& map : report.stability.maps) cells += map.cells.size();
  for (const report::ReportClip& clip : report.clips) clips += !clip.file.empty();
  return {{"scene", report.accuracy.scene},
          {"title", report.accuracy.title},
          {"horizon_s", report.accuracy.horizon},
          {"runs", runs},
          {"cells", cells},
          {"clips", clips}};
}

int run(const options::StudyOptions& options, const program::Common& common) {
  film::require_ffmpeg();
  options::tell_old_keys(options.inputs, common);
  const std::size_t methods = std::size_t(std::ranges::count_if(
      options::chosen_contenders(options),
      [](const options::Contender& one) { return one.candidate.settings.empty(); }));
  const double share = kForClips * 3 / 4 * double(report::kMostBytes);
  const std::size_t scenes = options.inputs.scenes.size();
  const auto most = std::size_t(share / double(std::max<std::size_t>(1, methods * scenes)));
  std::vector<report::SceneReport> reports;
  std::vector<program::Journal> journals;
  for (const std::string& scene : options.inputs.scenes) {
    options::StudyOptions one = options;
    one.scene = scene;
    Measured measured;
    measure_scene(one, most, common, measured);
    reports.push_back(std::move(measured.report));
    for (program::Journal& journal : measured.journals) journals.push_back(std::move(journal));
  }
  const std::string page = report::report_page(reports);
  if (page.size() > report::kMostBytes) {
    throw program::Misuse(
        fmt::format("a page of {:.1f} MB is beyond {} MB: expected fewer scenes, fewer "
                    "--methods or --quick",
                    double(page.size()) / 1e6, report::kMostBytes / 1'000'000));
  }
  const std::filesystem::path folder =
      options.inputs.several()
          ? std::filesystem::path(options.out.empty() ? "out" : options.out)
          : options::results_folder(options.inputs.scenes.front(), options.out, false);
  const std::filesystem::path file = folder / "report.html";
  render::AtomicFile out(file);
  out.write(page);
  out.commit();
  for (program::Journal& journal : journals) journal.finish();
  program::Json json = {
      {"report", file.string()}, {"bytes", page.size()}, {"machine", options::machine()}};
  for (const report::SceneReport& report : reports) json["scenes"].push_back(json_of(report));
  render::write_output(common.json ? program::json_text(json) + "\n" : file.string() + "\n");
  return program::kDone;
}

}  // namespace
}  // namespace report_command

void add_report(CLI::App& app, program::Program& program) {
  using namespace report_command;
  program::Command command = program::add_command(
      app, program, "report", "Report accuracy, costs, failures and clips of scenes on one page",
      R"(  taut report scenes/rope_swing.toml
  taut report scenes/rope_swing.toml scenes/bench_stick.toml --quick
  taut report scenes/rope_swing.toml --methods springs,xpbd,direct --budget 120

Writes report.html, one self-contained file under 5 MB that works offline: speed against accuracy,
errors over time, a small clip of each method, and where each fails. Every point, cell and clip has
the command that makes it. An interrupted report resumes when the same command is run again.)");
  const auto options = std::make_shared<options::StudyOptions>();
  options::add_study_options(command, *options, kBudgets);
  options->features = options::study_features("report");
  command.callback([options, &program] {
    program.run = [options, &program] {
      options::choose_budget(*options, kBudgets);
      return run(*options, program.common);
    };
  });
}

}  // namespace taut::cli
