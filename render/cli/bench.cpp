// taut bench: what each frame costs each method, as in the paper's Figure 5.
#include "sim/study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "render/atomic_file.h"
#include "render/chart/gnuplot.h"
#include "render/interrupt.h"
#include "render/program/command.h"
#include "render/program/note.h"
#include "render/program/terminal.h"
#include "render/study/bench_results.h"

namespace taut::cli {
namespace {

constexpr int kFrames = 100;

struct Options {
  StudyOptions study;
  std::vector<std::size_t> particles;
  std::string against;  // empty: springs or, without them, the first method
};

Problem frames_of(const Scene& scene) {
  Problem problem{scene.world, {}, scene.timeline};
  for (int k = 1; k <= kFrames; ++k) problem.times.push_back(static_cast<double>(k) / scene.fps);
  return problem;
}

BenchBlock measure(const StudyOptions& options, const std::vector<Contender>& contenders,
                   std::size_t particles, double seconds) {
  const Scene scene = study_scene(options, particles);
  std::vector<Candidate> candidates;
  for (const Contender& one : contenders) {
    if (one.method->missing.empty()) candidates.push_back(one.candidate);
  }
  BenchOptions limits;
  limits.repeats = options.quick ? 5 : 25;
  limits.seconds = seconds / 2 / static_cast<double>(std::max<std::size_t>(1, candidates.size()));
  limits.pause = stop_if_interrupted;
  std::vector<BenchRow> measured = bench(frames_of(scene), candidates, limits);
  BenchBlock block;
  block.particles = particles;
  std::size_t next = 0;
  for (const Contender& one : contenders) {
    if (one.method->missing.empty()) {
      block.rows.push_back(std::move(measured[next++]));
    } else {
      BenchRow row;
      row.candidate = one.candidate;
      row.failure = one.method->missing;
      block.rows.push_back(std::move(row));
    }
  }
  const double duration = static_cast<double>(kFrames) / scene.fps;
  block.paper = paper_ratio(options, contenders, particles, duration, seconds / 2);
  return block;
}

}  // namespace

BenchResults measure_bench(const StudyOptions& options, const std::vector<std::size_t>& particles,
                           const std::string& asked, bool quiet) {
  const std::vector<Contender> contenders = chosen_contenders(options);
  const bool springs =
      std::ranges::find(contenders, "springs", &Contender::label) != contenders.end();
  const std::string against = !asked.empty() ? asked
                              : springs      ? "springs"
                                             : contenders.front().label;
  BenchResults results{study_scene(options), contenders, against, {}};
  if (std::ranges::find(results.contenders, against, &Contender::label) ==
      results.contenders.end()) {
    throw Misuse(fmt::format("--against: {} is not among the methods timed", against));
  }
  const double seconds = options.budget / static_cast<double>(particles.size());
  for (const std::size_t n : particles) {
    if (!quiet) note("timing {} particles\n", n);
    results.blocks.push_back(measure(options, results.contenders, n, seconds));
  }
  return results;
}

namespace {

int run(const Options& options, const Common& common) {
  require_gnuplot();
  const BenchResults results =
      measure_bench(options.study, options.particles, options.against, common.quiet);
  const std::filesystem::path folder = study_folder(options.study);
  write_csv(bench_table(results), folder / "bench");
  write_csv(bench_frames_table(results), folder / "bench_frames");
  const Table settings = settings_table(results.paper()),
              equal = equal_error_table(results.paper());
  write_csv(settings, folder / "bench_paper_ratio");
  write_csv(equal, folder / "bench_equal_error");
  write_chart(bench_chart(results), folder / "bench");
  if (common.json) {
    write_output(bench_json(results));
  } else {
    write_output(table_text(bench_table(results)));
    if (!settings.rows.empty()) {
      write_output(fmt::format("\nSprings that cost {} times as much as impulse, which is the "
                               "paper's ratio:\n",
                               kPaperRatio) +
                   table_text(settings) +
                   "\nThe cost of the error that impulse has at one step a frame, and of the least "
                   "that it reaches:\n" +
                   table_text(equal));
    }
    write_output("\n" + machine() + "\n");
  }
  if (!common.quiet) {
    note("{}/bench: .csv .svg .png, _frames.csv, _paper_ratio.csv, _equal_error.csv\n",
         folder.string());
  }
  return kDone;
}

}  // namespace

void add_bench(CLI::App& app, Program& program) {
  Command command = add_command(app, program, "bench", "What each frame costs each method",
                                R"(  taut bench scenes/rope_swing.toml
  taut bench scenes/rope_swing.toml --quick --methods impulse,springs,direct
  taut bench scenes/rope_swing.toml --particles 21 --against xpbd --methods impulse,xpbd)");
  const auto options = std::make_shared<Options>();
  add_study_options(command, options->study, 120);
  options->study.follows = Follows::pins;
  options->study.among_obstacles = true;
  command
      .add_option("--particles", options->particles,
                  "Numbers of particles of the first connector, with commas; default: 11,21,41,81, "
                  "and 11,21 for --quick")
      .delimiter(',')
      .range(2, 100000);
  command.add_option("--against", options->against,
                     "The method that others are compared with; default: springs, or the first");
  command.callback([options, &program] {
    program.run = [options, &program] {
      const bool quick = options->study.quick;
      if (quick) options->study.budget = std::min(options->study.budget, 20.0);
      if (options->particles.empty()) {
        options->particles =
            quick ? std::vector<std::size_t>{11, 21} : std::vector<std::size_t>{11, 21, 41, 81};
      }
      return for_each_study(options->study, program.common, [&](const StudyOptions& study) {
        return run({study, options->particles, options->against}, program.common);
      });
    };
  });
}

}  // namespace taut::cli
