#include "sim/evaluation/energy_balance.h"

#include <algorithm>
#include <cmath>

#include "sim/measure/measure.h"
#include "sim/topology/span.h"

namespace taut::study {
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
