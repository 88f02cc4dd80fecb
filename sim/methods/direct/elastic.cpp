#include "sim/methods/direct/elastic.h"

#include <algorithm>
#include <cmath>

#include "sim/material/forces.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

constexpr double kRate = 3;           // 1/s, tolerances that the steps of a second may err in all
constexpr double kShare = 0.3;        // tolerances that a step may err
constexpr double kSolved = 1e-2;      // of that error: where Newton's method ends
constexpr double kExactly = 1e-13;    // of the length: the same with a fixed step
constexpr double kSwing = 0.15;       // of sqrt(L/g): how long an error of velocities goes on
constexpr double kRoundings = 1e-13;  // of the length: no estimate says anything of less
constexpr double kSafety = 0.9, kMostChange = 5;
constexpr double kKept = 1.2;         // a step that could be longer by less stays
constexpr double kShortest = 1e-13;   // s
constexpr double kFirstShare = 1e-2;  // of what falls through the tolerance
constexpr double kOrder = 4;          // of the error's estimate in a step

void copy_state(const Connector& from, Connector& to) {
  to.position = from.position;
  to.velocity = from.velocity;
  to.end_turn = from.end_turn;
}

}  // namespace

Elastic::Elastic(const StepOptions& options, std::function<std::unique_ptr<Method>()> make)
    : options_(options), rest_method_(make()) {}

void Elastic::prepare(const World& world) {
  rest_ = world;
  rest_.connectors.clear();
  rest_connectors_.clear();
  std::vector<std::unique_ptr<Part>> before = std::move(parts_);
  parts_.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.sections.empty()) {
      rest_connectors_.push_back(c);
      rest_.connectors.push_back(connector);
      continue;
    }
    auto part = std::make_unique<Part>();
    part->connector = c;
    part->world.time = world.time;
    part->world.gravity = world.gravity;
    part->world.air = world.air;
    part->world.connectors = {connector};
    for (Hold& hold : part->world.connectors[0].holds) {
      if (hold.to.kind != Attachment::Kind::body) continue;
      const auto known = std::ranges::find(part->bodies, hold.to.body);
      const std::size_t index = static_cast<std::size_t>(known - part->bodies.begin());
      if (known == part->bodies.end()) {
        part->bodies.push_back(hold.to.body);
        part->world.bodies.push_back(world.bodies[hold.to.body]);
      }
      hold.to.body = index;
    }
    part->step.rebuild(part->world);
    if (parts_.size() < before.size()) part->h = before[parts_.size()]->h;
    parts_.push_back(std::move(part));
  }
  rest_.topology = structure(rest_);
}

void Elastic::advance(World& world, double until) {
  const double from = world.time;
  for (std::size_t i = 0; i < rest_connectors_.size(); ++i) {
    copy_state(world.connectors[rest_connectors_[i]], rest_.connectors[i]);
  }
  rest_.bodies = world.bodies;
  rest_.time = from;
  rest_method_->advance(rest_, until);
  world.bodies = rest_.bodies;
  for (std::size_t i = 0; i < rest_connectors_.size(); ++i) {
    copy_state(rest_.connectors[i], world.connectors[rest_connectors_[i]]);
  }
  for (const auto& part : parts_) {
    Connector &own = part->world.connectors[0], &shown = world.connectors[part->connector];
    if (part->world.time != from || own.position != shown.position ||
        own.velocity != shown.velocity) {
      part->known = false;
    }
    copy_state(shown, own);
    part->world.time = from;
    follow(*part, until);
    copy_state(own, shown);
  }
  place_held(world, until);
}

double Elastic::allowed(const Part& part, double h) const {
  return std::max(std::min(kRate * h, kShare) * options_.tolerance,
                  kRoundings * part.world.connectors[0].length);
}

/// The error (m) allowed to Newton's method: its error of places is one of velocities as well, over
/// the step, and those move the particles on.
double Elastic::left_open(const Part& part, double h) const {
  const double length = part.world.connectors[0].length;
  const double swing = kSwing * std::sqrt(length / std::max(part.world.gravity.norm(), 1.0));
  const double step_share = std::min(1.0, h / swing);
  const double exact = kExactly * length;
  return step_share * (options_.step > 0 ? exact : std::max(exact, kSolved * allowed(part, h)));
}

double Elastic::first_step(const Part& part) const {
  const double fall = std::max(part.world.gravity.norm(), 1.0);
  return kFirstShare * std::sqrt(2 * options_.tolerance / fall);
}

void Elastic::follow(Part& part, double until) {
  RadauStep& step = part.step;
  double time = part.world.time;
  if (!part.known) step.load(time);
  part.known = true;
  const bool fixed = options_.step > 0;
  if (part.h == 0) part.h = fixed ? options_.step : first_step(part);
  while (time < until) {
    const double wish = (fixed ? options_.step : part.h) / options_.finer;
    const double count = std::max(1.0, std::ceil((until - time) / wish * (1 - 1e-9)));
    double h = (until - time) / count;
    double error = 0, limit = 0;
    for (bool taken = false; !taken;) {
      check_stop();
      limit = allowed(part, h);
      const std::uint64_t before = step.iterations();
      const RadauStep::Result result = step.attempt(time, h, left_open(part, h), limit);
      const std::uint64_t solves = step.iterations() - before;
      ++counters_.steps;
      counters_.solves += solves;
      counters_.cycles += static_cast<double>(solves + 1) * step.cycles();
      error = result.error;
      taken = result.converged && (fixed || !(error > limit));
      if (taken) break;
      ++counters_.rejected;
      const double shorter =
          result.converged ? kSafety * std::pow(limit / error, 1 / kOrder) : 0.25;
      h *= std::clamp(shorter, 0.1, 0.7);
      part.h = h * options_.finer;
      if (h < kShortest) give_up(part);
    }
    step.accept();
    time = until - time - h <= 1e-9 * h ? until : time + h;
    part.world.time = time;
    if (fixed) continue;
    const double ratio = error > 0 ? kSafety * std::pow(limit / error, 1 / kOrder) : kMostChange;
    // A step that was cut to end at `until` says nothing against the longer one.
    const double next = h * options_.finer * std::clamp(ratio, 1 / kMostChange, kMostChange);
    if (ratio < 1 || next > kKept * part.h) part.h = next;
  }
  step.store(part.world);
}

void Elastic::give_up(Part& part) const {
  part.step.store(part.world);
  const Connector& connector = part.world.connectors[0];
  std::vector<material::StretchElement> stretches;
  material::add_stretches(connector, 0, 0, stretches);
  const auto* pressed = material::pressed_together(stretches, connector.position.data()->data());
  throw Diverged("direct", part.world.time, counters_.steps, connector.name,
                 pressed ? pressed->link : 0,
                 pressed ? material::kPressedTogether : "no step is small enough");
}

Counters Elastic::counters() const {
  Counters sum = rest_method_->counters();
  sum += counters_;
  return sum;
}

}  // namespace taut::direct
