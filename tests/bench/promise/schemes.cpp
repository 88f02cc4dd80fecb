#include "tests/bench/promise/schemes.h"

#include <fmt/format.h>

#include <deque>
#include <ostream>

#include "sim/methods/direct/integrator.h"
#include "tests/bench/promise/reference.h"

namespace taut::promise {
namespace {

using direct::Integrator;

void follow(const Drawn& drawn, double tolerance, std::ostream& out) {
  constexpr std::array<std::string_view, 3> kNames = {"dop853", "adams", "rosenbrock"};
  constexpr std::array<std::string_view, 4> kLimits = {"error", "waves", "frame", "longest"};
  World world = drawn.world;
  Division division;
  direct::StepOptions options;
  options.tolerance = tolerance * drawn.length;
  std::deque<direct::Integrator> parts;
  for (const Component& component : division.divide(world)) {
    parts.emplace_back(options).follow(component);
    parts.back().load(world);
  }
  Counters counters;
  for (int frame = 1; frame <= kDuration * kFps; ++frame) {
    const double time = frame / static_cast<double>(kFps);
    for (direct::Integrator& part : parts) part.advance(world, time, counters);
    world.time = time;
    place_prescribed(world, time);
    for (direct::Integrator& part : parts) {
      part.store(world);
      const direct::Integrator::Step& step = part.last_step();
      out << fmt::format("{},{},{},{:.4g},{:.4g},{},{}\n", drawn.seed, kKinds[drawn.kind],
                         tolerance, step.waves, step.length,
                         kLimits[static_cast<std::size_t>(step.limit)], kNames[step.scheme]);
    }
    place_carried(world);
  }
}

}  // namespace

void write_schemes(const Drawn& drawn, std::span<const double> tolerances, std::ostream& out) {
  for (const double tolerance : tolerances) {
    try {
      follow(drawn, tolerance, out);
    } catch (
        const direct::Integrator::StepTooSmall&) {  // links at their full length between two holds
    }
  }
}

}  // namespace taut::promise
