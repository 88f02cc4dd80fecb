#include "sim/methods/span_impulse.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/methods/span_side.h"

namespace taut::methods {
namespace {

constexpr double kSameLine = 0.5;  // cosine of the most that a span turns between limit and now

/// The impulse (N s) on b, its reaction on a, and the ways they have gone since (N s^2).
void exchange(const Side& a, const Vec3& arm_a, const Side& b, const Vec3& arm_b,
              const Vec3& impulse, const Vec3& impulse_time) {
  a.kick(-impulse, arm_a);
  b.kick(impulse, arm_b);
  a.shift(-impulse_time, arm_a);
  b.shift(impulse_time, arm_b);
}

/// The distances between which a span's ends are left alone, m.
struct DistanceLimits {
  double shortest, longest;
  double exact;  // so near a limit is at it

  DistanceLimits(const Span& span, const LinkLimits& limits)
      : shortest(span.folds ? 0 : limits.shortest * span.length),
        longest(limits.longest * span.length),
        exact(kAtLimit * span.length) {}
};

/// A span without length is a joint: it holds in every direction. Half a step ago is when the
/// forces of a step act that keep it closed.
bool close_joint(const Side& a, const Side& b, double dt) {
  const Vec3 arm_a = a.arm_before(dt / 2), arm_b = b.arm_before(dt / 2);
  const Mat3 inverse =
      Mat3(a.inverse_mass_matrix(arm_a, a.arm) + b.inverse_mass_matrix(arm_b, b.arm)).inverse();
  const Vec3 shift = inverse * (a.point() - b.point());
  const Vec3 impulse = inverse * (a.velocity_of(a.arm) - b.velocity_of(b.arm));
  exchange(a, arm_a, b, arm_b, impulse, shift);
  return true;
}

/// Equation (5) as it stands in the paper: each end responds as if the other were fixed, its moment
/// of inertia is a number (about the axis that resists most), and nothing clamps it. It has moved
/// with the mean of its velocities before and after. Returns the larger of the two impulses, N s.
double printed_impulse(const Side& a, const Side& b, const Span& span, const Vec3& along,
                       double separation_speed, double restitution, double dt) {
  double largest = 0;
  const auto apply = [&](const Side& side, const Vec3& toward_other) {
    if (side.inverse_mass == 0) return;
    double inverse = side.inverse_mass;
    if (side.body) {
      const Mat3 inertia = side.body->mass_properties.inertia;
      const double moment = inertia.diagonal().maxCoeff();
      if (moment > 0) inverse += side.arm.squaredNorm() / moment;
    }
    const double size =
        separation_speed * (1 + restitution) / inverse * mass_ratio(span, side.inverse_mass);
    side.kick(size * toward_other, side.arm);
    side.shift(dt / 2 * size * toward_other, side.arm);
    largest = std::max(largest, size);
  };
  apply(a, along);
  apply(b, -along);
  return largest;
}

}  // namespace

void SpanImpulses::prepare(const World& world) {
  rotations_.clear();
  for (const Body& body : world.bodies) rotations_.emplace_back(body.mass_properties.inertia);
}

void SpanImpulses::watch(const World& world, Span& span, double time,
                         std::vector<Event>& events) const {
  if (!span.taut || span.length == 0) return;
  const std::vector<Vec3>& position = world.connectors[span.connector].position;
  const double distance = (position[span.b.particle] - position[span.a.particle]).norm();
  const DistanceLimits range(span, limits_);
  if (distance >= range.longest - range.exact || distance <= range.shortest + range.exact) return;
  span.taut = false;
  events.push_back({Event::Kind::slack, time, span.connector, span.index, 0});
}

bool SpanImpulses::act(World& world, Span& span, double time, double dt,
                       std::vector<Event>& events) const {
  if (span.a.kind == SpanEnd::Kind::follower || span.b.kind == SpanEnd::Kind::follower) {
    return false;
  }
  const Side a(world, span, span.a, rotations_), b(world, span, span.b, rotations_);
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  if (inverse_mass == 0 || (a.body && a.body == b.body)) return false;
  const auto log = [&](Event::Kind kind, double when, double size) {
    events.push_back({kind, when, span.connector, span.index, size});
  };
  const Vec3 gap = b.point() - a.point();
  const double distance = gap.norm();
  const DistanceLimits range(span, limits_);
  const bool is_long = distance > range.longest + range.exact;
  if (!is_long && distance >= range.shortest - range.exact) return false;
  if (span.length == 0 && !as_printed_) return close_joint(a, b, dt);

  // From here on, `sign` makes whatever leads farther beyond the limit positive.
  const double sign = is_long ? 1 : -1;
  const double limit = is_long ? range.longest : range.shortest;
  const Vec3 along = gap / distance;
  const double separation_speed = sign * along.dot(b.velocity_of(b.arm) - a.velocity_of(a.arm));
  const double restitution = world.connectors[span.connector].restitution;
  if (as_printed_) {
    if (separation_speed <= 0) return false;
    const double size =
        printed_impulse(a, b, span, sign * along, separation_speed, restitution, dt);
    if (!span.taut) {
      log(Event::Kind::taut, time, 0);
      log(Event::Kind::impulse, time, size);
    }
    span.taut = true;
    return false;  // both ends have responded; nothing more to settle in this step
  }

  // The span passed its limit `ago`; in steady tension that is half a step. `pull` is what gravity
  // adds to the separation speed in a second.
  const bool impact = separation_speed > 0 && !span.taut;
  const double pull = sign * along.dot(b.fall(world.gravity) - a.fall(world.gravity));
  const double excess = sign * (distance - limit);
  double ago = separation_speed > 0 ? std::min(excess / separation_speed, dt) : 0;
  if (impact)
    ago = std::min(excess / std::max(separation_speed - pull * ago / 2, separation_speed / 2), dt);
  Vec3 line = (b.point_before(ago) - a.point_before(ago)).normalized();
  Vec3 arm_a = a.arm_before(ago), arm_b = b.arm_before(ago);
  Vec3 response =
      a.inverse_mass_along(line, arm_a, a.arm) + b.inverse_mass_along(line, arm_b, b.arm);
  // The shift along `line` that brings the ends back to their limit: |gap + shift response| =
  // limit.
  const double p = gap.dot(response), q = response.squaredNorm();
  const double c = distance * distance - limit * limit;
  const bool turns = line.dot(along) < kSameLine || p * p < q * c;
  double shift = turns ? 0 : -c / (p + std::sqrt(p * p - q * c));
  if (turns) {  // too fast to be followed back: as the ends are now, to first order
    ago = 0;
    line = along;
    arm_a = a.arm, arm_b = b.arm;
    response = a.inverse_mass_along(line, arm_a, a.arm) + b.inverse_mass_along(line, arm_b, b.arm);
    shift = (limit - distance) / line.dot(response);
  }
  double size = 0;
  if (impact) {
    const Vec3 then =
        a.inverse_mass_along(line, arm_a, arm_a) + b.inverse_mass_along(line, arm_b, arm_b);
    const double speed = sign * line.dot(b.velocity_of(arm_b) - a.velocity_of(arm_a));
    // Thrown back at the moment of the impact, and pulled since; else the span stays taut.
    const double back = restitution * mass_ratio(span, inverse_mass) * (speed - pull * ago);
    const bool rebounds = back > pull * ago;
    const double wanted = rebounds ? pull * ago - back : 0;
    size = sign * (wanted - speed) / line.dot(then);
    if (rebounds) shift -= sign * ago * (back - pull * ago / 2) / line.dot(then);
    log(Event::Kind::taut, time - ago, 0);
    log(Event::Kind::impulse, time - ago, std::abs(size));
  } else if (separation_speed >
             0) {  // steady: the distance of the ends does not change when the step ends
    const Vec3 now = turns ? along : Vec3((gap + shift * response).normalized());
    size = -now.dot(b.velocity_of(b.arm) - a.velocity_of(a.arm)) / now.dot(response);
  }
  span.taut = true;
  exchange(a, arm_a, b, arm_b, size * line, shift * line);
  return true;
}

}  // namespace taut::methods
