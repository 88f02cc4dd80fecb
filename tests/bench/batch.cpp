// Many ropes at once: nanoseconds per particle and step, beside the least that this processor could
// take for as many operations, and how much faster than real time 10,000 ropes are.
#include "sim/batch/batch.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <thread>

#include "scenes/load/load_scene.h"
#include "sim/evaluation/run.h"

namespace taut {
namespace {

using batch::Width;

/// Counts what the kernel does with it.
struct Counted {
  double value = 0;
  static inline double additions = 0, products = 0, divisions = 0;

  friend Counted operator+(Counted a, Counted b) { return ++additions, Counted{a.value + b.value}; }
  friend Counted operator-(Counted a, Counted b) { return ++additions, Counted{a.value - b.value}; }
  friend Counted operator*(Counted a, Counted b) { return ++products, Counted{a.value * b.value}; }
  friend Counted operator/(Counted a, Counted b) { return ++divisions, Counted{a.value / b.value}; }
  friend Counted operator*(double a, Counted b) { return Counted{a} * b; }
  friend Counted operator/(double a, Counted b) { return Counted{a} / b; }
  friend Counted operator-(Counted a, double b) { return a - Counted{b}; }
  friend bool operator>(Counted a, Counted b) { return a.value > b.value; }
  Counted operator-() const { return {-value}; }
  Counted& operator+=(Counted other) { return *this = *this + other; }
  Counted& operator*=(Counted other) { return *this = *this * other; }
};

/// Operations of a step, per particle of a rope of 21.
struct Operations {
  double additions, products, divisions;

  Operations() {
    constexpr std::size_t kLinks = 20, kSteps = 100;
    std::vector<Counted> group(batch::group_size(kLinks, 1), Counted{1});
    const Counted pull[3] = {{0}, {-9.81}, {0}};
    Counted::additions = Counted::products = Counted::divisions = 0;
    batch::Steps<double> steps{kSteps, 1e-3, false, reinterpret_cast<const double*>(pull), 0};
    batch::advance_group<Counted>(kLinks, group.data(), steps);
    constexpr double kParticles = (kLinks + 1.0) * kSteps;
    additions = Counted::additions / kParticles;
    products = Counted::products / kParticles;
    divisions = Counted::divisions / kParticles;
  }
};

/// Independent sums and products, one of each in turn, and independent quotients: what the
/// arithmetic units take at best. Returns seconds per vector for a pair, and for a quotient.
template <typename V, typename Scalar>
[[gnu::always_inline]] inline void busy(std::size_t repeats, Scalar factor, double& pair,
                                        double& quotient) {
  // As many as latency times units, each a variable: arrays would stay in memory.
  const V one = V{} + factor;
  V x0 = one, x1 = one, x2 = one, x3 = one, x4 = one, x5 = one, x6 = one;
  V y0 = one, y1 = one, y2 = one, y3 = one, y4 = one, y5 = one, y6 = one;
  const auto hold = [](V& value) { asm volatile("" : "+v"(value)); };
  const auto both = [&](V& x, V& y) {
    x = x * factor;
    y = y + factor;
    hold(x);
    hold(y);
  };
  const auto divide = [&](V& x) {
    x = factor / x;
    hold(x);
  };
  const double start = thread_seconds();
  for (std::size_t i = 0; i < repeats; ++i) {
    both(x0, y0), both(x1, y1), both(x2, y2), both(x3, y3);
    both(x4, y4), both(x5, y5), both(x6, y6);
  }
  const double middle = thread_seconds();
  for (std::size_t i = 0; i < repeats / 10; ++i) {
    divide(x0), divide(x1), divide(x2), divide(x3), divide(x4), divide(x5), divide(x6);
  }
  const double end = thread_seconds();
  constexpr double kChains = 7;
  pair = (middle - start) / (static_cast<double>(repeats) * kChains);
  quotient = (end - middle) / (static_cast<double>(repeats / 10) * kChains);
}

template <typename Scalar>
using Vector16 [[gnu::vector_size(16)]] = Scalar;
template <typename Scalar>
using Vector32 [[gnu::vector_size(32)]] = Scalar;
template <typename Scalar>
using Vector64 [[gnu::vector_size(64)]] = Scalar;

template <typename Scalar>
void busy_single(std::size_t n, Scalar factor, double& pair, double& quotient) {
  busy<Scalar>(n, factor, pair, quotient);
}
template <typename Scalar>
void busy_sse2(std::size_t n, Scalar factor, double& pair, double& quotient) {
  busy<Vector16<Scalar>>(n, factor, pair, quotient);
}
template <typename Scalar>
[[gnu::target("avx2")]] void busy_avx2(std::size_t n, Scalar factor, double& pair,
                                       double& quotient) {
  busy<Vector32<Scalar>>(n, factor, pair, quotient);
}
template <typename Scalar>
[[gnu::target("avx512f")]] void busy_avx512(std::size_t n, Scalar factor, double& pair,
                                            double& quotient) {
  busy<Vector64<Scalar>>(n, factor, pair, quotient);
}

/// s per particle and step: as many additions and multiplications as the kernel's, the two side by
/// side, and its divisions, with every unit busy all the time.
template <typename Scalar>
double floor_of(batch::Width width) {
  static const Operations operations;
  const auto function = width == batch::Width::single ? busy_single<Scalar>
                        : width == batch::Width::sse2 ? busy_sse2<Scalar>
                        : width == batch::Width::avx2 ? busy_avx2<Scalar>
                                                      : busy_avx512<Scalar>;
  double least = INFINITY;
  for (int repeat = 0; repeat < 5; ++repeat) {
    double pair = 0, quotient = 0;
    function(200000, Scalar(0.9999), pair, quotient);
    least = std::min(least, std::max(operations.additions, operations.products) * pair +
                                operations.divisions * quotient);
  }
  constexpr double kBytes[] = {sizeof(Scalar), 16, 32, 64};  // of a vector
  return least * sizeof(Scalar) / kBytes[static_cast<int>(width)];
}

World ropes(std::size_t count) {
  World world = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/bench_swing.toml", false).world;
  const Connector rope = world.connectors[0];
  world.connectors.assign(count, rope);
  return world;
}

constexpr double kStep = 1.0 / 1920, kFrame = 1.0 / 60;  // s; an error of 0.3% of the length

template <typename Scalar>
void Step(benchmark::State& state) {
  const auto width = static_cast<batch::Width>(state.range(0));
  if (width > batch::widest()) return state.SkipWithError("not on this processor");
  const World world = ropes(256);
  batch::Batch<Scalar> batch(world, kStep, width);
  double frame = 0, spent = 0;
  for (auto _ : state) {
    const double before = thread_seconds();
    batch.advance(++frame * kFrame);
    spent += thread_seconds() - before;
    if (frame == 60) {
      state.PauseTiming();
      batch = batch::Batch<Scalar>(world, kStep, width);
      frame = 0;
      state.ResumeTiming();
    }
  }
  const double particles = 256.0 * 21 * kFrame / kStep * static_cast<double>(state.iterations());
  const double floor = floor_of<Scalar>(width);
  state.counters["ns"] = 1e9 * spent / particles;
  state.counters["floor"] = 1e9 * floor;
  state.counters["ratio"] = spent / particles / floor;
}
BENCHMARK_TEMPLATE(Step, double)->DenseRange(0, 3)->ArgName("width");
BENCHMARK_TEMPLATE(Step, float)->DenseRange(0, 3)->ArgName("width");

/// A second of 10,000 ropes. The processor time of all threads, over the cores: what the wall clock
/// would say if nothing else ran.
template <typename Scalar>
void TenThousandRopes(benchmark::State& state) {
  const World world = ropes(10000);
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  for (auto _ : state) {
    state.PauseTiming();
    batch::Batch<Scalar> batch(world, kStep);
    state.ResumeTiming();
    for (int frame = 1; frame <= 60; ++frame) batch.advance(frame * kFrame, threads);
  }
  state.counters["times real time on all cores"] =
      benchmark::Counter(threads, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_TEMPLATE(TenThousandRopes, double)
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(TenThousandRopes, float)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace taut
