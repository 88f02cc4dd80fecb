#include "sim/methods/direct/integrator.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/kernels.h"

namespace taut::direct {
namespace {

/// The first step turns a link by about so much (rad).
constexpr double kFirstTurn = 0.02;

bool driven(const World& world, const Component& component) {
  for (const SpanRange& span : component.spans) {
    for (const std::size_t particle : {span.first, span.last}) {
      const Hold* hold = hold_at(world.connectors[span.connector], particle);
      if (hold && is_prescribed(world, hold->to) && !rests(hold->to, world.time)) return true;
    }
  }
  return false;
}

}  // namespace

void Integrator::reserve(std::size_t links, std::size_t ends, std::size_t bodies) {
  planes_.reserve(links);
  system_.reserve(links, ends, bodies);
  arena_.reserve(kArrays, 3 * (links + 2 * ends + 2 * kLanes) + 7 * ends + kLanes);
}

void Integrator::plan(const World& world, const std::optional<Plane>& plane) {
  planned_at_ = world.time;
  system_.rebuild(world, component_, plane);
  arena_.reset(kArrays, system_.size());
  for (Slice* slice :
       {&q_, &v_, &a_, &q_before_, &v_before_, &q_between_, &v_between_, &first_, &inner_}) {
    *slice = arena_.make();
  }
  dop853_.make_arrays(arena_);
  verlet_.make_arrays(arena_);
  bdf_.make_arrays(arena_);
  fresh_ = started_ = false;
}

void Integrator::load(const World& world) {
  plan(world, planes_.find(world, component_, world.time, Vec3::Zero()));
  time_ = world.time;
  system_.load(world, q_.data(), v_.data());
  system_.project(time_, q_.data(), v_.data());
  system_.acceleration(time_, q_.data(), v_.data(), a_.data());
  const double speed = system_.turning(v_.data()), gain = system_.turning(a_.data());
  const double first =
      2 * kFirstTurn / (speed + std::sqrt(speed * speed + 2 * gain * kFirstTurn) + 1e-300);
  Controller::Component about;
  about.length = system_.length();
  about.shortest = system_.shortest();
  about.time_scale = system_.time_scale();
  about.driven = driven(world, component_);
  about.only_bodies_free = !system_.has_bodies() && system_.points() > 0;
  controller_.begin(about, system_.frequency(), std::min(first, 0.01));
}

void Integrator::refresh(Counters& counters) {
  if (fresh_) return;
  system_.acceleration(time_, q_.data(), v_.data(), a_.data());
  counters.solves += 1;
  counters.work += system_.work();
  fresh_ = true;
}

/// A hold has left the plane: goes on from where the last step ended, in another plane (a chain
/// that hangs still fits many) or in space.
bool Integrator::leave_plane(World& world) {
  const std::optional<Vec3> reason = system_.left_plane();
  if (!reason) return false;
  const double now = world.time;
  place_prescribed(world, time_);
  system_.store(world, q_.data(), v_.data());
  std::optional<Plane> plane;
  if (planned_at_ != time_) plane = planes_.find(world, component_, time_, *reason);
  plan(world, plane);
  system_.load(world, q_.data(), v_.data());
  place_prescribed(world, now);
  return true;
}

Outcome Integrator::attempt(const Step& step, Counters& counters) {
  const double memory = controller_.memory();
  if (step.scheme == Scheme::dop853) {
    refresh(counters);
    counters.solves += kStages - 1;
    counters.work += (kStages - 1) * system_.work();
    return dop853_.attempt(system_, time_, step.h, memory, q_.data(), v_.data(), a_.data(),
                           controller_.verlet_limit(system_.frequency()), controller_.span());
  }
  if (!started_) {
    refresh(counters);
    if (step.scheme == Scheme::verlet) {
      verlet_.begin(step.h, q_.data(), v_.data(), a_.data(), {inner_at_, inner_.data()},
                    {before_, first_.data()}, q_before_.data());
    } else {
      bdf_.begin(step.h, q_.data(), v_.data(), a_.data(), q_before_.data(), v_before_.data());
    }
    before_ = time_ - step.h;
    started_ = true;
  }
  counters.solves += 1;
  const double last = time_ - before_;
  fresh_ = false;
  if (step.scheme == Scheme::verlet) {
    counters.work += system_.work();
    return verlet_.attempt(system_, time_, step.h, last, controller_.span(), q_.data(),
                           q_before_.data());
  }
  counters.work += 2 * system_.work();
  return bdf_.attempt(system_, time_, step.h, last, controller_.span(), q_.data(), v_.data(),
                      q_before_.data(), v_before_.data());
}

void Integrator::accept(const Step& step, Counters& counters) {
  counters.steps += 1;
  q_before_.swap(q_);
  v_before_.swap(v_);
  before_ = time_;
  time_ = step.end;
  fresh_ = false;
  if (step.scheme == Scheme::verlet) return verlet_.accept(q_, v_, v_before_);
  if (step.scheme == Scheme::bdf) return bdf_.accept(q_, v_);
  std::copy(a_.begin(), a_.end(), first_.begin());
  std::copy_n(dop853_.inner(), inner_.size(), inner_.begin());
  inner_at_ = before_ + Dop853Step::kInner * (time_ - before_);
  dop853_.swap_result(q_, v_);
  system_.project(time_, q_.data(), v_.data());
}

void Integrator::advance(World& world, double until, Counters& counters) {
  system_.attach(world);
  while (time_ < until) {
    const Scheme scheme = controller_.scheme();
    if (scheme == Scheme::dop853 || !started_) refresh(counters);
    if (leave_plane(world)) continue;
    const Step step = controller_.choose(time_, until, system_.frequency());
    if (!(time_ + step.h > time_)) throw StepTooSmall{time_};
    const Outcome outcome = attempt(step, counters);
    if (leave_plane(world)) continue;
    if (controller_.accept(step, outcome)) {
      accept(step, counters);
    } else {
      counters.rejected += 1;
      // The tensions are those of where the step led.
      fresh_ = false;
      if (step.scheme != Scheme::dop853) refresh(counters);
    }
    if (controller_.scheme() != step.scheme) {
      if (step.scheme == Scheme::verlet) system_.project(time_, q_.data(), v_.data());
      started_ = false;
      counters.handed_over += 1;
    }
  }
}

void Integrator::store(World& world) {
  if (time_ == world.time && controller_.scheme() == Scheme::dop853) {
    return system_.store(world, q_.data(), v_.data());
  }
  const double h = time_ - before_;
  kernels::hermite(q_.size(), h, (world.time - before_) / h, q_before_.data(), v_before_.data(),
                   q_.data(), v_.data(), q_between_.data(), v_between_.data());
  system_.project(world.time, q_between_.data(), v_between_.data());
  system_.store(world, q_between_.data(), v_between_.data());
  fresh_ = false;
}

}  // namespace taut::direct
