// taut work-precision: the cost of an error for each method, scene beside scene.
#include "render/study/work_precision.h"

#include <filesystem>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/program/command.h"
#include "render/program/output.h"

namespace taut::cli {
namespace work_precision_command {
namespace {

struct Options {
  options::StudyOptions study;                   // its scene is each of its inputs in turn
  std::vector<double> errors{1e-2, 1e-3, 1e-4};  // m
  bool markdown = false;
};

int run(const Options& options, const program::Common& common) {
  const program::PartOptions& part = options.study.part;
  if (part.is_part()) return studies::work_precision_part(options.study, options.errors, common);
  std::vector<studies::AccuracyStudy> studies;
  if (part.merge) {
    studies = studies::merged_work_precision(options.study, options.errors);
  } else {
    options::tell_old_keys(options.study.inputs, common);
    studies = studies::work_precision(options.study, options.errors, common.quiet);
  }
  const chart::Table detail = studies::cheapest_settings(studies, options.errors);
  if (!options.study.out.empty()) {
    options::write_csv(detail, std::filesystem::path(options.study.out) / "work_precision");
  }
  if (common.json) {
    program::Json json = {{"machine", options::machine()}, {"scenes", program::Json::array()}};
    for (const studies::AccuracyStudy& study : studies)
      json["scenes"].push_back(studies::work_precision_json(study, options.errors));
    render::write_output(program::json_text(json) + "\n");
    return program::kDone;
  }
  std::string output;
  for (const chart::Table& one : {studies::costs_of_errors(studies, options.errors), detail,
                                  studies::errors_not_attained(studies, options.errors)}) {
    if (one.rows.empty()) continue;
    if (!output.empty()) output += "\n";
    output += options.markdown ? chart::to_markdown(one) : program::table_text(one);
  }
  render::write_output(output);
  return program::kDone;
}

}  // namespace
}  // namespace work_precision_command

void add_work_precision(CLI::App& app, program::Program& program) {
  using namespace work_precision_command;
  program::Command command = program::add_command(
      app, program, "work-precision", "Cost of each method at given errors, for several scenes",
      R"(  taut work-precision scenes/bench_*.toml
  taut work-precision scenes/bench_*.toml --errors 0.01,0.001,0.0001 --markdown --out out/bench

For each error, the CPU milliseconds per simulated second of the cheapest settings whose RMS
position error stays below it while the scene's truth is predictable; in brackets, the ratio to the
cheapest method. Times are medians of runs in turn. Parts (--part 3/100) are separate processes, on
any machines that share the folder of --out: each times neighbouring runs one after another; --merge
makes the tables.)");
  const auto options = std::make_shared<Options>();
  options->study.budget = 120;
  options->study.features = options::study_features("work-precision");
  options::add_scene_options(command, options->study.inputs);
  command
      .add_option("--errors", options->errors,
                  "Errors, m, separated by commas; default: 0.01,0.001,0.0001")
      .delimiter(',')
      .positive();
  command.add_option("--out", options->study.out, "Folder for work_precision.csv; default: none");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, separated by commas; default: all")
      .delimiter(',');
  command
      .add_option("--budget", options->study.budget,
                  "CPU time for each scene, s, approximately; default: 120")
      .positive();
  command.add_flag("--quick", options->study.quick, "Try few settings of each method");
  command
      .add_option("--reference-step", options->study.reference_step,
                  "Score against direct at this step, s, instead of the truth")
      .positive();
  program::add_part_options(command, options->study.part, "runs");
  command.add_flag("--markdown", options->markdown, "Print the tables as Markdown");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
