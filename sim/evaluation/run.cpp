#include "sim/evaluation/run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/contact/capsule.h"
#include "sim/evaluation/energy_balance.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"

namespace taut::study {

std::vector<double> frame_times(double duration, int fps) {
  std::vector<double> times;
  for (int k = 0; k / static_cast<double>(fps) <= duration * (1 + 1e-12); ++k) {
    times.push_back(k / static_cast<double>(fps));
  }
  return times;
}

Run run(const Problem& problem, const MethodChoice& candidate, double cpu_cap,
        const std::function<void()>& tick) {
  const double until = problem.times.empty() ? 0 : problem.times.back();
  const std::string wrong = step_complaint(candidate.settings, until - problem.world.time);
  if (!wrong.empty()) throw std::invalid_argument(wrong);
  Simulation simulation(problem.world, make_method(candidate.name, candidate.settings),
                        problem.timeline);
  const EnergyBalance balance(problem.timeline);
  double level = energy(problem.world), frame = problem.world.time;
  const Vec3 momentum = linear_momentum(problem.world);
  const Vec3 weight = moving_mass(problem.world) * problem.world.gravity;
  Run result;
  result.reached = problem.world.time;
  const double start = thread_seconds();
  const WorkLimit limit({.cpu_time = cpu_cap});
  try {
    for (const double time : problem.times) {
      const double before = thread_seconds();
      simulation.advance_to(time);
      result.cpu += thread_seconds() - before;
      if (result.cpu > cpu_cap) throw OverLimit();
      if (tick) tick();
      const double now = energy(std::as_const(simulation).world());
      if (balance.intervened(frame, time)) level = now;
      frame = time;
      const double gained = now - level;
      const double stretch = stretch_max(std::as_const(simulation).world());
      if (!std::isfinite(gained) || !std::isfinite(stretch)) {
        result.end = Run::End::diverged;
        result.reason = "not finite";
        result.failed_at = time;
        break;
      }
      result.frames.push_back(simulation.state());
      result.reached = time;
      result.energy.push_back(gained);
      result.momentum.push_back((linear_momentum(std::as_const(simulation).world()) - momentum -
                                 (time - problem.world.time) * weight)
                                    .norm());
      result.energy_gain = std::max(result.energy_gain, gained);
      result.energy_loss = std::max(result.energy_loss, -gained);
      result.stretch.push_back(stretch);
      result.stretch_max = std::max(result.stretch_max, stretch);
      result.penetration_max = std::max(
          result.penetration_max, contact::penetration_max(std::as_const(simulation).world()));
    }
  } catch (const OverLimit&) {
    if (!limit.reached() && !(result.cpu > cpu_cap)) throw;  // it is that of a limit around this
    result.cpu = std::max(result.cpu, thread_seconds() - start);
    result.end = Run::End::over_cap;
    result.reason = text_of(Run::End::over_cap);
  } catch (const Diverged& error) {
    result.end = Run::End::diverged;
    result.reason = error.what();
    result.failed_at = error.time;
  } catch (const BadIntervention& error) {
    result.end = Run::End::diverged;
    result.reason = error.what();
    result.failed_at = error.time;
  }
  result.counters = simulation.method().counters();
  return result;
}

double time_run(const Problem& problem, const MethodChoice& candidate) {
  constexpr double kBrief = 2e-3;     // s; what ran before still fills the caches for part of it
  constexpr std::size_t kMost = 100;  // runs
  const auto seconds = [&] {
    Simulation simulation(problem.world, make_method(candidate.name, candidate.settings),
                          problem.timeline);
    const double before = thread_seconds();
    for (const double time : problem.times) simulation.advance_to(time);
    return thread_seconds() - before;
  };
  double sum = seconds();
  if (sum >= kBrief) return sum;
  std::vector<double> runs;
  do {
    runs.push_back(seconds());
    sum += runs.back();
  } while (sum < kBrief && runs.size() < kMost);
  const auto middle = runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2);
  std::ranges::nth_element(runs, middle);
  return *middle;
}

const char* text_of(Run::End end) {
  switch (end) {
    case Run::End::done:
      return "done";
    case Run::End::diverged:
      return "diverged";
    case Run::End::over_cap:
      return "over its CPU cap";
  }
  return "";
}

}  // namespace taut::study
