#include "tests/bench/floor.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "sim/evaluation/run.h"

namespace taut::bench {
namespace {

constexpr std::size_t kLength = 1000000;

/// The least of some repeats, which no other work of the machine has disturbed.
template <typename Work>
double least_seconds(Work work) {
  double least = 1;
  for (int repeat = 0; repeat < 20; ++repeat) {
    const double start = thread_seconds();
    work();
    least = std::min(least, thread_seconds() - start);
  }
  return least;
}

}  // namespace

double multiply_add_latency() {
  static const double latency = least_seconds([] {
                                  double x = 1, factor = 0.999, term = 1e-3;
                                  benchmark::DoNotOptimize(factor);
                                  benchmark::DoNotOptimize(term);
                                  for (std::size_t i = 0; i < kLength; ++i) x = x * factor + term;
                                  benchmark::DoNotOptimize(x);
                                }) /
                                kLength;
  return latency;
}

double byte_time() {
  constexpr std::size_t kNumbers = 1000, kRepeats = 1000;
  static const double time = least_seconds([] {
                               static std::vector<double> numbers(kNumbers, 1.0);
                               for (std::size_t k = 0; k < kRepeats; ++k) {
                                 for (double& number : numbers) number = -number;
                                 benchmark::ClobberMemory();
                               }
                             }) /
                             (kRepeats * kNumbers * 2 * sizeof(double));
  return time;
}

}  // namespace taut::bench
