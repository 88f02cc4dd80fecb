// The cost of interventions: a frame of the paper's method under a storm of them, sooner and later,
// one intervention against an ordinary step, and many of them on one rope.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <vector>

#include "sim/evaluation/run.h"
#include "sim/run/simulation.h"

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

/// CPU seconds that `what` takes.
template <class Work>
double timed(Work what) {
  const double before = thread_seconds();
  what();
  return thread_seconds() - before;
}

struct Cost {
  double interventions = 0, frames = 0;  // s, of all
  double steps = 0;
};

/// Half a second of a rope whose every frame begins with a pin or its release. An intervention's
/// cost is its own time and that of the frame behind it, less that of the same frame from the same
/// state by a method that has made everything anew. So the cost of a jump of velocities for any
/// solver, with its first step without a history, is the frame's and not the intervention's.
Cost swing(std::string_view method, std::size_t particles) {
  Simulation rope = simulation(method, particles);
  World& world = rope.world();
  Interventions& interventions = rope.interventions();
  interventions.reserve(world, 1, 0);
  rope.advance_to(kFrame);
  const double clock = timed([] {});
  Cost cost;
  std::uint64_t pin = 0;
  const auto intervene = [&](World& at) {
    if (pin != 0) {
      interventions.release(at, pin);
    } else {
      pin = interventions.pin(at, 0, 0.437).pin;
    }
  };
  for (int frame = 2; frame <= 30; ++frame) {
    World same = world;
    const auto ready = make_method(method, {});
    ready->advance(same, same.time);
    const std::uint64_t before = pin;
    const double own = timed([&] { intervene(world); });
    pin = before;
    intervene(same);
    pin = before != 0 ? 0 : world.pins;
    ready->advance(same, same.time);
    const double with = timed([&] { rope.advance_to(frame * kFrame); });
    const auto steps = static_cast<double>(ready->counters().steps);
    const double without = timed([&] { ready->advance(same, frame * kFrame); });
    cost.interventions += own + with - without - clock;
    cost.frames += without - clock;
    cost.steps += static_cast<double>(ready->counters().steps) - steps;
  }
  return cost;
}

/// An intervention in steps of the method's own and in frames, the steps of a simulation.
void Intervention(benchmark::State& state, std::string_view method) {
  constexpr double kCount = 29;
  const auto particles = static_cast<std::size_t>(state.range(0));
  std::vector<double> intervention, frame, step;  // s
  for (auto _ : state) {
    const Cost cost = swing(method, particles);
    intervention.push_back(cost.interventions / kCount);
    frame.push_back(cost.frames / kCount);
    step.push_back(cost.frames / cost.steps);
  }
  const auto median = [](std::vector<double>& values) {
    std::ranges::sort(values);
    return values[values.size() / 2];
  };
  const double one = median(intervention);
  state.counters["us"] = 1e6 * one;
  state.counters["in_frames"] = one / median(frame);
  state.counters["in_own_steps"] = one / median(step);
}

/// Pins or cuts that divide a slack rope, one after another in half a second, in scattered order.
void ManyOnOneRope(benchmark::State& state, bool cuts) {
  const auto count = static_cast<std::size_t>(state.range(0));
  World world;
  Connector rope = straight_connector("rope", 0.01 * double(count), 0.001 * double(count),
                                      2 * count + 1, Vec3::Zero(), Vec3(1, 0, 0));
  const Vec3 end(0.006 * double(count), 0, 0);
  rope.position = hanging_points(rope, Vec3::Zero(), end, world.gravity);
  rope.holds = {{0, {}}, {2 * count, {}}};
  rope.holds[1].to.point = end;
  world.connectors = {rope};
  Timeline timeline;
  for (std::size_t k = 0; k < count; ++k) {
    const double along = 0.01 * (double(k * 7919 % count) + 0.5);
    const double time = 0.1 + 0.5 * double(k) / double(count);
    if (cuts) {
      timeline.cuts.push_back({.along = along, .time = time});
    } else {
      timeline.pins.push_back({.along = along, .from = time, .to = {}});
    }
  }
  for (auto _ : state) {
    Simulation simulation(world, make_method("direct", {{"tolerance", 1e-2}}), timeline);
    simulation.advance_to(0.7);
  }
  state.counters["each"] = benchmark::Counter(
      double(count), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(ManyOnOneRope, pins, false)
    ->ArgName("pins")
    ->RangeMultiplier(10)
    ->Range(100, 10'000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ManyOnOneRope, cuts, true)
    ->ArgName("cuts")
    ->RangeMultiplier(10)
    ->Range(100, 10'000)
    ->Unit(benchmark::kMillisecond);

}  // namespace

void register_interventions() {
  for (const MethodInfo& method : all_methods()) {
    if (!method.missing.empty() || method.name == "sdfast") continue;
    const std::string name = "Intervention/" + std::string(method.name);
    auto* row = benchmark::RegisterBenchmark(name.c_str(), Intervention, method.name);
    row->ArgName("particles")->Arg(21)->Arg(101)->Unit(benchmark::kMillisecond);
  }
}

}  // namespace taut
