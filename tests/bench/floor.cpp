// What this machine can do at best: the floor that the other benchmarks are compared with.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <vector>

namespace {

/// The latency of a multiply-add whose operand is the result of the one before: what a sweep along
/// a chain waits for at each link, however wide the machine is.
void DependentMultiplyAdd(benchmark::State& state) {
  constexpr std::size_t kLength = 1000;
  double x = 1, factor = 0.999, term = 1e-3;
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(term);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kLength; ++i) x = x * factor + term;
    benchmark::DoNotOptimize(x);
  }
  state.counters["ns"] = benchmark::Counter(
      1e-9 * kLength, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(DependentMultiplyAdd);

/// Bytes read and written by a sum of two arrays, from memory that no cache holds.
void Bandwidth(benchmark::State& state) {
  std::vector<double> a(1 << 23, 1.0), b(1 << 23, 2.0);
  for (auto _ : state) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(a.size() * 24));
}
BENCHMARK(Bandwidth);

}  // namespace
