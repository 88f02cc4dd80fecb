// The cost of each frame for each candidate: the paper's Figure 5.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim/evaluation/run.h"
#include "sim/study/speed_accuracy.h"

namespace taut::study {

struct BenchRow {
  MethodChoice candidate;
  std::string failure;         // why it has no timings, or not of every frame
  std::vector<Spread> frames;  // s of CPU time per frame, over the repeats
  Spread mean;                 // s per frame: the mean of a repeat's frames, over the repeats
  double steps = 0;            // per frame
  std::size_t repeats = 0;
};

struct BenchOptions {
  std::size_t repeats = 15;     // at most
  double seconds = 10;          // of each candidate's stepping, after which it is repeated no more
  std::function<void()> pause;  // called between runs; may throw to stop
};

/// Times every frame of `problem` (its first time is where it starts) for every candidate.
/// Candidates take turns, one run each in every repeat, so that a disturbance of the machine meets
/// them all. Nothing but the stepping lies within the timed region.
std::vector<BenchRow> bench(const Problem& problem, std::span<const MethodChoice> candidates,
                            const BenchOptions& options);

}  // namespace taut::study
