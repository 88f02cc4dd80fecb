// What interventions cost: a frame of the paper's method under a storm of them, sooner and later,
// and one intervention against an ordinary step.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <vector>

#include "sim/simulation.h"
#include "sim/study/run.h"

namespace taut {
namespace {

constexpr double kFrame = 1.0 / 60;  // s

World hanging_rope(std::size_t particles) {
  World world;
  Connector rope =
      straight_connector("rope", 1, 0.2, particles, Vec3::Zero(), Vec3(1, -1, 0).normalized());
  rope.holds = {{0, {}}};
  world.connectors = {rope};
  finish(world);
  return world;
}

Simulation simulation(std::string_view method, std::size_t particles) {
  return {hanging_rope(particles), make_method(method, {})};
}

/// Pins and releases without end, one of them a frame: 3600 in a simulated minute.
class Storm {
 public:
  explicit Storm(Simulation& simulation) : simulation_(simulation) {
    simulation.interventions().reserve(simulation.world(), kMostPins, 0);
  }

  void intervene() {
    World& world = simulation_.world();
    Interventions& interventions = simulation_.interventions();
    const double what = share_(random_);
    if (pins_.size() == kMostPins || (!pins_.empty() && what < 0.5)) {
      const std::uint64_t oldest = pins_.front();
      pins_.erase(pins_.begin());
      // Refused where the rope is bent too sharply between two others: its turn comes again.
      if (interventions.release(world, oldest) != Outcome::done) pins_.push_back(oldest);
    } else {
      const Pinned pinned = interventions.pin(world, 0, 0.05 + 0.9 * share_(random_));
      if (pinned.outcome == Outcome::done) pins_.push_back(pinned.pin);
    }
  }

 private:
  static constexpr std::size_t kMostPins = 3;
  Simulation& simulation_;
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> share_{0, 1};
  std::vector<std::uint64_t> pins_;
};

/// A frame of the paper's method after so many others, each with an intervention.
void StormFrame(benchmark::State& state) {
  Simulation rope = simulation("impulse", 21);
  Storm storm(rope);
  const auto frame = [&] {
    storm.intervene();
    rope.advance_to(rope.world().time + kFrame);
  };
  for (std::int64_t i = 0; i < state.range(0); ++i) frame();
  for (auto _ : state) frame();
}
BENCHMARK(StormFrame)->ArgName("after")->Arg(0)->Arg(600)->Arg(3600)->Arg(36000);

/// The same frame with nothing but the swing, for comparison.
void CalmFrame(benchmark::State& state) {
  Simulation rope = simulation("impulse", 21);
  for (auto _ : state) rope.advance_to(rope.world().time + kFrame);
}
BENCHMARK(CalmFrame);

struct Cost {
  double cpu = 0;  // s
  double steps = 0;
};

/// Steps for half a second; with `interventions`, each frame begins with a pin or its release.
Cost swing(std::string_view method, std::size_t particles, bool interventions) {
  Simulation rope = simulation(method, particles);
  World& world = rope.world();
  rope.interventions().reserve(world, 1, 0);
  rope.advance_to(kFrame);
  const double cpu = thread_seconds();
  const auto steps = static_cast<double>(rope.method().counters().steps);
  std::uint64_t pin = 0;
  for (int frame = 2; frame <= 30; ++frame) {
    if (interventions && pin == 0) {
      pin = rope.interventions().pin(world, 0, 0.43).pin;
    } else if (interventions) {
      rope.interventions().release(world, pin);
      pin = 0;
    }
    rope.advance_to(frame * kFrame);
  }
  return {thread_seconds() - cpu, static_cast<double>(rope.method().counters().steps) - steps};
}

/// What an intervention adds, beyond the steps that are taken, to what they cost: itself, and all
/// that the method makes anew for it. In ordinary steps, which is the claim, and in microseconds.
void Intervention(benchmark::State& state, std::string_view method) {
  const auto particles = static_cast<std::size_t>(state.range(0));
  std::vector<double> step, intervention;  // s
  for (auto _ : state) {
    const Cost plain = swing(method, particles, false), pinned = swing(method, particles, true);
    step.push_back(plain.cpu / plain.steps);
    intervention.push_back((pinned.cpu - pinned.steps * step.back()) / 29);
  }
  const auto median = [](std::vector<double>& values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
  };
  const double one = median(step), other = median(intervention);
  state.counters["step_us"] = 1e6 * one;
  state.counters["intervention_us"] = 1e6 * other;
  state.counters["in_steps"] = other / one;
}

const bool registered = [] {
  for (const MethodInfo& method : methods()) {
    if (!method.missing.empty() || method.name == "sdfast") continue;
    const std::string name = "Intervention/" + std::string(method.name);
    auto* row = benchmark::RegisterBenchmark(name.c_str(), Intervention, method.name);
    row->ArgName("particles")->Arg(21)->Arg(101)->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace taut
