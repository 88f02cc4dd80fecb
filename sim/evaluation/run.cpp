#include "sim/evaluation/run.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/contact/capsule.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"
#include "sim/topology/components.h"

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

namespace {

std::vector<Setting> values_of(const SettingInfo& setting, bool thin) {
  const std::vector<Setting>& all = setting.sweep;
  if (!thin || all.size() <= 3 || !std::holds_alternative<double>(all.front())) return all;
  return {all.front(), all[all.size() / 2], all.back()};
}

}  // namespace

std::vector<MethodChoice> sweep(const MethodInfo& method, bool thin) {
  std::vector<MethodChoice> candidates{{std::string(method.name), {}}};
  for (const SettingInfo& setting : method.settings) {
    if (setting.sweep.empty()) continue;
    std::vector<MethodChoice> wider;
    for (const MethodChoice& candidate : candidates) {
      for (const Setting& value : values_of(setting, thin)) {
        wider.push_back(candidate);
        wider.back().settings[std::string(setting.name)] = value;
      }
    }
    candidates = std::move(wider);
  }
  return candidates;
}

namespace {

// Gauss's rule of four points on [0, 1].
constexpr double kPlaces[] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813,
                              0.93056815579702629};
constexpr double kWeights[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                               0.17392742256872693};

}  // namespace

EnergyBalance::EnergyBalance(const Timeline& timeline) {
  for (const TimedPin& pin : timeline.pins) {
    interventions_.push_back({pin.from, pin.from + pin.over});
    interventions_.push_back({pin.until, pin.until});
  }
  for (const TimedCut& cut : timeline.cuts) interventions_.push_back({cut.time, cut.time});
}

bool EnergyBalance::intervened(double from, double until) const {
  return std::ranges::any_of(
      interventions_, [&](const Interval& one) { return one.until >= from && one.from <= until; });
}

double EnergyBalance::next(const World& world) {
  const double now = energy(world), from = time_;
  std::vector<Part> after = parts(world);
  if (!begun_ || intervened(from, world.time) || after.size() != before_.size()) {
    level_ = now;
  } else {
    for (std::size_t i = 0; i < after.size(); ++i)
      level_ += work(world, before_[i], after[i], from);
  }
  begun_ = true;
  time_ = world.time;
  before_ = std::move(after);
  return now - level_;
}

std::vector<EnergyBalance::Part> EnergyBalance::parts(const World& world) {
  if (has_spans(world) || has_winches(world)) {  // massless, or of a mass that changes
    complete_ &= is_closed(world);
    return {};
  }
  std::vector<Part> all;
  for (const Component& component : division_.divide(world)) {
    Part part;
    const auto add = [&](double mass, const Vec3& position, const Vec3& velocity) {
      part.mass += mass;
      part.centre += mass * position;
      part.momentum += mass * velocity;
    };
    for (const std::size_t b : component.bodies) {
      const Body& body = world.bodies[b];
      add(body.mass_properties.mass, body.position, body.velocity);
    }
    for (const SpanRange& span : component.spans) {
      const Connector& connector = world.connectors[span.connector];
      for (std::size_t i = span.first; i <= span.last; ++i) {
        const Hold* hold = find_hold(connector, i);
        if (!hold) {
          add(connector.particle_mass[i], connector.position[i], connector.velocity[i]);
        } else if (is_prescribed(world, hold->to)) {
          part.holds.push_back(hold->to);
        }
      }
    }
    if (part.mass > 0) part.centre /= part.mass;
    all.push_back(std::move(part));
  }
  return all;
}

/// The work (J) done on the part since `from`.
double EnergyBalance::work(const World& world, const Part& before, const Part& after, double from) {
  const double dt = world.time - from;
  const auto motion = [&](const Attachment& hold, double share) {
    return hold_motion(world, hold, from + share * dt);
  };
  const auto moves = [&](const Attachment& hold) {
    return std::ranges::any_of(
        kPlaces, [&](double share) { return !motion(hold, share).velocity.isZero(); });
  };
  if (!std::ranges::any_of(after.holds, moves)) return 0;
  if (after.holds.size() > 1) {
    complete_ = false;
    return 0;
  }
  const Attachment& hold = after.holds.front();
  const PointMotion start = motion(hold, 0), end = motion(hold, 1);
  const Vec3 way = after.centre - before.centre;
  const Vec3 first = before.momentum, last = after.momentum;
  double bent = 0;  // integral of h'' . P
  for (std::size_t i = 0; i < std::size(kPlaces); ++i) {
    const double s = kPlaces[i];
    // The derivative of Hermite's cubic, times the mass.
    const Vec3 momentum = 6 * s * (1 - s) * after.mass / dt * way + (1 - s) * (1 - 3 * s) * first +
                          s * (3 * s - 2) * last;
    bent += kWeights[i] * dt * motion(hold, s).acceleration.dot(momentum);
  }
  return end.velocity.dot(last) - start.velocity.dot(first) - bent -
         after.mass * world.gravity.dot(end.position - start.position);
}

}  // namespace taut::study
