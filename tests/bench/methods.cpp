// Every method on the swing of 21 particles: nanoseconds per particle of a step and of a solve,
// beside the floor: what one sweep down the chain and one up wait for, two multiply-adds a
// particle, and the bytes of its position and velocity, read and written.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "scenes/load/load_scene.h"
#include "sim/evaluation/run.h"
#include "tests/bench/floor.h"

namespace taut {
namespace {

constexpr double kDuration = 0.25, kFrame = 1.0 / 60;  // s, before the whip of the swing

void swing(benchmark::State& state, const std::string& method) {
  const scenes::Scene scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/bench_swing.toml", false);
  double spent = 0, steps = 0, solves = 0;
  for (auto _ : state) {
    Simulation simulation = scenes::start(scene, {method, {}});
    simulation.advance_to(kFrame);  // workspaces are made
    const Counters before = simulation.method().counters();
    const double from = thread_seconds();
    for (int frame = 2; frame * kFrame <= kDuration; ++frame) {
      simulation.advance_to(frame * kFrame);
    }
    spent += thread_seconds() - from;
    const Counters& after = simulation.method().counters();
    steps += static_cast<double>(after.steps - before.steps);
    solves += static_cast<double>(after.solves - before.solves);
  }
  const double particles = 21, numbers = 6;
  const double floor = std::max(2 * bench::multiply_add_latency(),
                                2 * numbers * sizeof(double) * bench::byte_time());
  state.counters["ns_step"] = 1e9 * spent / (steps * particles);
  if (solves > 0) state.counters["ns_solve"] = 1e9 * spent / (solves * particles);
  state.counters["floor"] = 1e9 * floor;
  state.counters["ratio"] = spent / (std::max(solves, steps) * particles) / floor;
}

const bool kRegistered = [] {
  for (const MethodInfo& method : all_methods()) {
    if (method.reference || !method.missing.empty()) continue;
    const std::string name(method.name);
    benchmark::RegisterBenchmark(("Swing/" + name).c_str(), swing, name)
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
}  // namespace taut
