// The results of `taut bench` as tables, a chart and JSON.
#pragma once

#include <string>
#include <vector>

#include "render/options/study_options.h"
#include "sim/study/bench.h"
#include "sim/study/paper_ratio.h"

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

}  // namespace taut::studies
