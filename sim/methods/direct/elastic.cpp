#include "sim/methods/direct/elastic.h"

#include <algorithm>
#include <cmath>

#include "sim/links/mechanism.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/system/system.h"

namespace taut::direct {
namespace {

constexpr double kRate = 3;           // 1/s, tolerances that the steps of a second may err in all
constexpr double kShare = 0.3;        // tolerances that a step may err
constexpr double kSolved = 1e-2;      // of that error: where Newton's method ends
constexpr double kExactly = 1e-13;    // of the length: the same with a fixed step
constexpr double kRoundings = 1e-13;  // of the length: no estimate says anything of less
constexpr double kFirstShare = 1e-2;  // of what falls through the tolerance
constexpr double kOrder = 4;          // of the error's estimate in a step

void copy_motion(const Connector& from, Connector& to) {
  to.position = from.position;
  to.velocity = from.velocity;
  to.end_turn = from.end_turn;
}

}  // namespace

void Elastic::rebuild(const World& world, std::size_t connector) {
  connector_ = connector;
  bodies_.clear();
  own_ = {};
  own_.gravity = world.gravity;
  own_.air = world.air;
  own_.connectors = {world.connectors[connector]};
  for (Hold& hold : own_.connectors[0].holds) {
    if (hold.to.kind != Attachment::Kind::body) continue;
    const auto known = std::ranges::find(bodies_, hold.to.body);
    const auto index = static_cast<std::size_t>(known - bodies_.begin());
    if (known == bodies_.end()) {
      bodies_.push_back(hold.to.body);
      own_.bodies.push_back(world.bodies[hold.to.body]);
    }
    hold.to.body = index;
  }
  step_.rebuild(own_);
  known_ = false;
}

void Elastic::advance(World& world, double until, Counters& counters) {
  counters_ = &counters;
  Connector &own = own_.connectors[0], &shown = world.connectors[connector_];
  if (!known_ || own_.time != world.time || own.position != shown.position ||
      own.velocity != shown.velocity) {
    copy_motion(shown, own);
    own_.time = world.time;
    step_.load(own_.time);
    controller_.start(own_.time);
    known_ = true;
  }
  controller_.follow(*this, until, counters);
  own_.time = until;
  step_.store(own_);
  copy_motion(own, shown);
}

double Elastic::allowed(double h) const {
  const double length = own_.connectors[0].length;
  const double share = std::min(kRate * options_.finer * h, kShare);
  return std::max(share * options_.asked(length) / std::pow(options_.finer, kOrder),
                  kRoundings * length);
}

/// The error (m) allowed to Newton's method: its error of places is one of velocities as well, over
/// the step, and those move the particles on.
double Elastic::left_open(double h) const {
  const double length = own_.connectors[0].length;
  const double step_share = std::min(1.0, h / velocity_time_of(length));
  const double exact = kExactly * length;
  return step_share * (options_.step > 0 ? exact : std::max(exact, kSolved * allowed(h)));
}

double Elastic::first_step() const {
  const double fall = std::max(own_.gravity.norm(), 1.0);
  return kFirstShare * std::sqrt(2 * options_.tolerance / fall) / options_.finer;
}

double Elastic::longest_step(double) {
  return kNever;
}

double Elastic::order() const {
  return kOrder;
}

bool Elastic::lands(double, double) const {
  return true;
}

Attempt Elastic::attempt(double time, double h, double) {
  const double limit = allowed(h);
  const std::uint64_t before = step_.iterations();
  const RadauStep::Result result = step_.attempt(time, h, left_open(h), limit);
  const std::uint64_t solves = step_.iterations() - before;
  counters_->solves += solves;
  counters_->cycles += static_cast<double>(solves + 1) * step_.cycles();
  return {result.converged, result.error, limit};
}

void Elastic::accept(double) {
  step_.accept();
}

void Elastic::give_up(double time) {
  step_.store(own_);
  Mechanism mechanism;
  mechanism.rebuild(own_);
  std::vector<double> state;
  mechanism.load(own_, state);
  throw no_step(own_, mechanism, state.data(), time, counters_->steps);
}

}  // namespace taut::direct
