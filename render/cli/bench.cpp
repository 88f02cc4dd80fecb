// taut bench: the cost of each frame for each method, as in the paper's Figure 5.
#include <fmt/format.h>

#include <memory>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/chart/chart.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/bench_results.h"
#include "sim/study/speed_accuracy.h"

namespace taut::cli {
namespace bench_command {
namespace {

constexpr options::Budgets kBudgets{.usual = 120, .quick = 20};

struct Options {
  options::StudyOptions study;
  std::vector<std::size_t> particles;
  std::string against;  // empty: springs or, without them, the first method
};

int run(const Options& options, const program::Common& common) {
  chart::require_gnuplot();
  const studies::BenchResults results =
      studies::measure_bench(options.study, options.particles, options.against, common.quiet);
  const std::filesystem::path folder = options::study_folder(options.study);
  options::write_csv(studies::bench_table(results), folder / "bench");
  options::write_csv(studies::bench_frames_table(results), folder / "bench_frames");
  const chart::Table settings = studies::settings_table(results),
                     equal = studies::equal_error_table(results);
  options::write_csv(settings, folder / "bench_paper_ratio");
  options::write_csv(equal, folder / "bench_equal_error");
  chart::write_chart(studies::bench_chart(results), folder / "bench");
  if (common.json) {
    render::write_output(studies::bench_json(results));
  } else {
    render::write_output(program::table_text(studies::bench_table(results)));
    if (!settings.rows.empty()) {
      render::write_output(
          fmt::format("\nSprings that cost {} times as much as impulse, which is the "
                      "paper's ratio:\n",
                      study::kPaperRatio) +
          program::table_text(settings) +
          "\nThe cost of the error that impulse has at one step a frame, and of the least "
          "that it reaches:\n" +
          program::table_text(equal));
    }
    render::write_output("\n" + options::machine() + "\n");
  }
  if (!common.quiet) {
    program::note("{}/bench: .csv .svg .png, _frames.csv, _paper_ratio.csv, _equal_error.csv\n",
                  folder.string());
  }
  return program::kDone;
}

}  // namespace
}  // namespace bench_command

void add_bench(CLI::App& app, program::Program& program) {
  using namespace bench_command;
  program::Command command =
      program::add_command(app, program, "bench", "CPU time per frame of each method",
                           R"(  taut bench scenes/rope_swing.toml
  taut bench scenes/rope_swing.toml --quick --methods impulse,springs,direct
  taut bench scenes/rope_swing.toml --particles 21 --against xpbd --methods impulse,xpbd)");
  const auto options = std::make_shared<Options>();
  options::add_study_options(command, options->study, kBudgets);
  options->study.features = options::study_features("bench");
  command
      .add_option("--particles", options->particles,
                  "Numbers of particles of the first connector, separated by commas; default: "
                  "11,21,41,81, or 11,21 with --quick")
      .delimiter(',')
      .range(2, 100000);
  command.add_option("--against", options->against,
                     "Method to compare the others with; default: springs, or the first");
  command.callback([options, &program] {
    program.run = [options, &program] {
      const bool quick = options->study.quick;
      options::choose_budget(options->study, kBudgets);
      if (options->particles.empty()) {
        options->particles =
            quick ? std::vector<std::size_t>{11, 21} : std::vector<std::size_t>{11, 21, 41, 81};
      }
      return options::for_each_study(
          options->study, program.common, [&](const options::StudyOptions& study) {
            return run({study, options->particles, options->against}, program.common);
          });
    };
  });
}

}  // namespace taut::cli
