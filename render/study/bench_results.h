// taut bench and taut claims: measurements, and their results as tables, a chart and JSON.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "render/options/study_options.h"
#include "sim/study/speed_accuracy.h"

namespace taut::studies {

/// The timings at one number of particles.
struct BenchBlock {
  std::size_t particles = 0;
  std::vector<study::BenchRow> rows;  // one per contender
  study::PaperRatio paper;
};

struct BenchResults {
  scenes::Scene scene;
  std::vector<options::Contender> contenders;
  std::string against;  // the contender that others are compared with
  std::vector<BenchBlock> blocks;
};

/// Times every contender at every number of particles, within about the options' budget.
BenchResults measure_bench(const options::StudyOptions& options,
                           const std::vector<std::size_t>& particles, const std::string& against,
                           bool quiet);

/// One row per number of particles and contender: time per frame, ratio, settings, failures.
chart::Table bench_table(const BenchResults& results);
/// The settings at which the paper's ratio appears, and costs at equal error.
chart::Table settings_table(const BenchResults& results);
chart::Table equal_error_table(const BenchResults& results);
/// The time of every frame.
chart::Table bench_frames_table(const BenchResults& results);
/// Time by the number of particles, time of each frame, and the paper's ratio.
chart::Chart bench_chart(const BenchResults& results);
std::string bench_json(const BenchResults& results);

// Measurements behind the paper's claims of one scene.

// Particles: as many as the scenes of ropes have, and a long chain.
inline constexpr std::size_t kFew = 21, kMany = 101;

/// The evidence for the claims.
struct Evidence {
  BenchResults bench;
  std::vector<double> errors;       // RMS against truth, share of the length; per contender
  std::vector<double> differences;  // mean of the segments against dynamic constraints, m
  double horizon = 0;               // s, of both
  double length = 0;                // m
  double always = 0;                // cost of impulse with h = 0 over that with its own h
  std::vector<double> pinned;       // as errors, with the connector's middle held as well

  /// Among the contenders, the paper's method of that role, or a form of it.
  std::size_t at(PaperRole role, std::string_view form = {}) const {
    return options::place_of(bench.contenders, role, form);
  }
  bool has(PaperRole role) const {
    const std::size_t c = at(role);
    return c < bench.contenders.size() && bench.blocks[0].rows[c].failure.empty();
  }
  /// CPU s per frame.
  double cost(PaperRole role, std::size_t block = 0, std::string_view form = {}) const {
    return bench.blocks[block].rows[at(role, form)].mean.median;
  }
  /// The interquartile range of the frames' medians, as a share of their median.
  double unevenness(PaperRole role) const {
    std::vector<double> frames;
    for (const study::Spread& frame : bench.blocks[0].rows[at(role)].frames) {
      frames.push_back(frame.median);
    }
    const study::Spread all = study::spread(std::move(frames));
    return (all.high - all.low) / all.median;
  }
  double real_time() const { return 1.0 / bench.scene.fps; }
};

/// Measures; says on standard error how far it is unless `quiet`. Throws Misuse where nothing of
/// the scene is predictable.
Evidence gather_evidence(const options::StudyOptions& options, bool quiet);

}  // namespace taut::studies
