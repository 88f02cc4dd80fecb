#include "sim/methods/direct/integrator.h"

#include <algorithm>
#include <cmath>

namespace taut::direct {

void Integrator::reserve(std::size_t links, std::size_t ends, std::size_t bodies) {
  planes_.reserve(links);
  system_.reserve(links, ends, bodies);
  arena_.reserve(kArrays, 3 * (links + 2 * ends + 2 * kLanes) + 7 * ends + kLanes);
}

void Integrator::plan(const World& world, const std::optional<Plane>& plane) {
  planned_at_ = world.time;
  system_.rebuild(world, component_, plane);
  arena_.reset(kArrays, system_.size());
  for (Slice* slice : {&q_, &v_, &a_}) *slice = arena_.make();
  dop853_.make_arrays(arena_);
}

void Integrator::load(const World& world) {
  plan(world, planes_.find(world, component_, world.time, Vec3::Zero()));
  time_ = world.time;
  system_.load(world, q_.data(), v_.data());
  system_.project(time_, q_.data(), v_.data());
  fresh_ = false;
  step_ = 1e-3;
}

void Integrator::refresh(Counters& counters) {
  if (fresh_) return;
  system_.acceleration(time_, q_.data(), v_.data(), a_.data());
  frequency_ = system_.frequency();
  counters.solves += 1;
  counters.work += system_.work();
  fresh_ = true;
}

bool Integrator::leave_plane(World& world) {
  const std::optional<Vec3> reason = system_.left_plane();
  if (!reason) return false;
  place_prescribed(world, time_);
  world.time = time_;
  system_.store(world, q_.data(), v_.data());
  std::optional<Plane> plane;
  if (planned_at_ != time_) plane = planes_.find(world, component_, time_, *reason);
  plan(world, plane);
  system_.load(world, q_.data(), v_.data());
  fresh_ = false;
  return true;
}

void Integrator::advance(World& world, double until, Counters& counters) {
  system_.attach(world);
  const double memory = 0.15 * system_.time_scale();
  while (time_ < until) {
    refresh(counters);
    if (leave_plane(world)) continue;
    const double left = until - time_;
    double wish = std::min(step_, Dop853Step::kStable / frequency_);
    if (options_.step > 0) wish = options_.step;
    const double parts = std::max(1.0, std::ceil(left / wish - 1e-6));
    const double h = left / parts;
    if (!(time_ + h > time_)) throw StepTooSmall{time_};
    const double error = dop853_.attempt(system_, time_, h, memory, q_.data(), v_.data(), a_.data());
    counters.solves += kStages - 1;
    counters.work += (kStages - 1) * system_.work();
    if (leave_plane(world)) continue;
    const double excess = options_.step > 0 ? 0 : error / std::min(0.02, 15 * h) / options_.tolerance;
    const double scale =
        std::isfinite(excess) ? 0.9 * std::pow(std::max(excess, 1e-10), -1.0 / 7) : 0.4;
    step_ = h * std::clamp(scale, 0.2, 4.0);
    if (!(excess <= 1)) {
      counters.rejected += 1;
      continue;
    }
    dop853_.swap_result(q_, v_);
    time_ = parts == 1 ? until : time_ + h;
    system_.project(time_, q_.data(), v_.data());
    counters.solves += 2;
    counters.steps += 1;
    fresh_ = false;
  }
}

void Integrator::store(World& world) { system_.store(world, q_.data(), v_.data()); }

}  // namespace taut::direct
