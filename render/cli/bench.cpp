// taut bench: what each frame costs each method, as in the paper's Figure 5.
#include "sim/study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/study_options.h"
#include "render/interrupt.h"

namespace taut::cli {
namespace {

constexpr int kFrames = 100;
constexpr double kPaperRatio = 2.76;  // the particle system's time over the paper's method's

struct Options {
  StudyOptions study;
  std::vector<std::size_t> particles{11, 21, 41, 81};
  std::string against = "springs";
};

/// The timings at one number of particles.
struct Block {
  std::size_t particles = 0;
  std::vector<BenchRow> rows;  // one per contender
};

Problem frames_of(const Scene& scene) {
  Problem problem{scene.world, {}};
  for (int k = 1; k <= kFrames; ++k) problem.times.push_back(static_cast<double>(k) / scene.fps);
  return problem;
}

Block measure(const Options& options, const std::vector<Contender>& contenders,
              std::size_t particles) {
  const Scene scene = study_scene(options.study, particles);
  std::vector<Candidate> candidates;
  for (const Contender& one : contenders) {
    if (one.method->missing.empty()) candidates.push_back(one.candidate);
  }
  BenchOptions limits;
  limits.repeats = options.study.quick ? 5 : 25;
  limits.seconds = options.study.budget / static_cast<double>(options.particles.size()) /
                   static_cast<double>(std::max<std::size_t>(1, candidates.size()));
  limits.pause = stop_if_interrupted;
  std::vector<BenchRow> measured = bench(frames_of(scene), candidates, limits);
  Block block{particles, {}};
  std::size_t next = 0;
  for (const Contender& one : contenders) {
    if (one.method->missing.empty()) {
      block.rows.push_back(std::move(measured[next++]));
    } else {
      block.rows.push_back({one.candidate, std::string(one.method->missing), {}, {}, 0});
    }
  }
  return block;
}

/// The cost of `row` in terms of the contender that others are compared with: how many times
/// faster it is; zero where one of the two has no timing.
double ratio(const Block& block, const std::vector<Contender>& contenders, std::size_t row,
             const std::string& against) {
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    if (contenders[c].label != against || !block.rows[c].failure.empty()) continue;
    if (!block.rows[row].failure.empty()) return 0;
    return block.rows[c].mean.median / block.rows[row].mean.median;
  }
  return 0;
}

Table summary(const std::vector<Block>& blocks, const std::vector<Contender>& contenders,
              const Options& options) {
  Table table{{"particles", "method", "settings", "µs per frame", "low quartile", "high quartile",
               "times as fast as " + options.against, "repeats", "remark"},
              {}};
  for (const Block& block : blocks) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      const BenchRow& row = block.rows[c];
      const bool timed = row.failure.empty() && row.repeats > 0;
      const auto micro = [&](double seconds) { return timed ? rounded(1e6 * seconds) : "-"; };
      const double factor = ratio(block, contenders, c, options.against);
      table.add({std::to_string(block.particles), contenders[c].label,
                 describe(row.candidate.settings), micro(row.mean.median), micro(row.mean.low),
                 micro(row.mean.high), factor > 0 ? rounded(factor) : "-",
                 std::to_string(row.repeats), row.failure});
    }
  }
  return table;
}

Table frame_table(const std::vector<Block>& blocks, const std::vector<Contender>& contenders) {
  Table table{
      {"particles", "method", "frame", "median (s)", "low quartile (s)", "high quartile (s)"}, {}};
  for (const Block& block : blocks) {
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      const auto& frames = block.rows[c].frames;
      for (std::size_t k = 0; k < frames.size(); ++k) {
        table.add({std::to_string(block.particles), contenders[c].label, std::to_string(k + 1),
                   fmt::format("{:.9g}", frames[k].median), fmt::format("{:.9g}", frames[k].low),
                   fmt::format("{:.9g}", frames[k].high)});
      }
    }
  }
  return table;
}

std::string finding(const Block& block, const std::vector<Contender>& contenders,
                    const Options& options) {
  std::size_t fastest = 0, slowest = 0;
  bool found = false;
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    if (!block.rows[c].failure.empty() || block.rows[c].repeats == 0) continue;
    const auto cost = [&](std::size_t i) { return block.rows[i].mean.median; };
    if (!found || cost(c) < cost(fastest)) fastest = c;
    if (!found || cost(c) > cost(slowest)) slowest = c;
    found = true;
  }
  if (!found) return "No method could be timed";
  const double factor = ratio(block, contenders, fastest, options.against);
  std::string line =
      fmt::format("At {} particles {} is fastest with {} µs a frame", block.particles,
                  contenders[fastest].label, rounded(1e6 * block.rows[fastest].mean.median));
  if (factor > 0 && contenders[fastest].label != options.against) {
    line += fmt::format(", {} times as fast as {}", rounded(factor), options.against);
  }
  return line + fmt::format("; {} is slowest with {} µs", contenders[slowest].label,
                            rounded(1e6 * block.rows[slowest].mean.median));
}

Chart picture(const std::vector<Block>& blocks, const std::vector<Contender>& contenders,
              const Options& options, const Scene& scene) {
  const Block* middle = &blocks.front();
  for (const Block& block : blocks) {
    if (block.particles == scene.world.connectors.front().particles()) middle = &block;
  }
  Chart chart;
  chart.title = finding(*middle, contenders, options);
  chart.subtitle = fmt::format(
      "{}: time of stepping alone at each method's default settings, errors not equal. Medians and "
      "quartiles over interleaved repeats. {}",
      scene.title, machine());
  chart.columns = blocks.size() > 1 ? 2 : 1;
  chart.width = 1280;
  Panel frames{fmt::format("each frame, {} particles", middle->particles),
               {"frame (1/" + std::to_string(scene.fps) + " s)"},
               {"time per frame (µs)", true},
               {},
               {},
               {},
               {}};
  Panel growth{"mean of a frame, by the number of particles",
               {"particles", true},
               {"time per frame (µs)", true},
               {},
               {},
               {},
               {}};
  for (const Block& block : blocks) {
    const auto n = static_cast<double>(block.particles);
    growth.x.tics.emplace_back(n, std::to_string(block.particles));
  }
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    Series line{contenders[c].label, contenders[c].style, true, false, false, {}};
    const auto& row = middle->rows[c].frames;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (row[k].median > 0)
        line.points.push_back({static_cast<double>(k + 1), 1e6 * row[k].median});
    }
    Series means{contenders[c].label, contenders[c].style, true, true, false, {}};
    for (const Block& block : blocks) {
      const Spread& mean = block.rows[c].mean;
      if (block.rows[c].repeats == 0) continue;
      means.points.push_back({static_cast<double>(block.particles), 1e6 * mean.median, kAuto, kAuto,
                              1e6 * mean.low, 1e6 * mean.high});
    }
    growth.series.push_back(std::move(means));
    frames.series.push_back(std::move(line));
  }
  for (Panel* panel : {&frames, &growth}) {
    panel->rules.push_back({1e6 / scene.fps, false, "real time"});
  }
  chart.panels = {growth, frames};
  if (blocks.size() == 1) chart.panels = {frames};
  return chart;
}

int run(const Options& options, const Common& common) {
  const std::vector<Contender> contenders = chosen_contenders(options.study);
  const Scene scene = study_scene(options.study);
  std::vector<Block> blocks;
  for (const std::size_t particles : options.particles) {
    if (!common.quiet) fmt::print(stderr, "timing {} particles\n", particles);
    blocks.push_back(measure(options, contenders, particles));
  }
  const Table table = summary(blocks, contenders, options);
  const std::filesystem::path folder = study_folder(options.study);
  write_csv(table, folder / "bench");
  write_csv(frame_table(blocks, contenders), folder / "bench_frames");
  write_chart(picture(blocks, contenders, options, scene), folder / "bench");
  if (common.json) {
    nlohmann::ordered_json json = {{"scene", options.study.scene}, {"machine", machine()}};
    for (const auto& row : table.rows) {
      nlohmann::ordered_json object;
      for (std::size_t i = 0; i < row.size(); ++i) {
        object[table.columns[i]] = row[i];
      }
      json["rows"].push_back(std::move(object));
    }
    write_output(json.dump(2) + "\n");
  } else {
    write_output(
        to_text(table) +
        fmt::format("\nThe paper has its method {} times as fast as a particle system.\n{}\n",
                    kPaperRatio, machine()));
  }
  if (!common.quiet) {
    fmt::print(stderr, "{}/bench: .csv .svg .png, bench_frames.csv\n", folder.string());
  }
  return kDone;
}

}  // namespace

void add_bench(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "bench", "What each frame costs each method",
                                  R"(  taut bench scenes/rope_swing.toml
  taut bench scenes/rope_swing.toml --quick --methods impulse,springs,direct
  taut bench scenes/rope_swing.toml --particles 21 --against xpbd)");
  const auto options = std::make_shared<Options>();
  add_study_options(command, options->study, 120);
  command
      .add_option("--particles", options->particles,
                  "Numbers of particles of the first connector, with commas")
      ->delimiter(',')
      ->check(CLI::Range(2, 100000));
  command.add_option("--against", options->against,
                     "The method that others are compared with; default: springs");
  command.callback([options, &program] {
    program.run = [options, &program] {
      if (options->study.quick) options->study.budget = std::min(options->study.budget, 20.0);
      return run(*options, program.common);
    };
  });
}

}  // namespace taut::cli
