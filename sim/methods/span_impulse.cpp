#include "sim/methods/span_impulse.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace taut {
namespace {

// A rebound that is over within so few steps is none: the span is coming to rest, taut.
constexpr std::uint64_t kNoRebound = 2;
constexpr double kExact = 1e-12;  // of the length: a span so near its limit is at it

/// An end of a span as a thing that impulses move: a point at `arm` from the centre of mass of a
/// body, or a particle (arm zero). World axes.
struct Side {
  double inverse_mass = 0;              // 1/kg; zero: does not answer to impulses
  Mat3 inverse_inertia = Mat3::Zero();  // 1/(kg m^2)
  Vec3 arm = Vec3::Zero();              // m
  Vec3 spin = Vec3::Zero();             // rad/s
  Vec3* centre = nullptr;               // m, where the state keeps it
  Vec3* velocity = nullptr;             // m/s, of the centre
  Body* body = nullptr;

  Side(World& world, const Span& span, const SpanEnd& end,
       const std::vector<FreeRotation>& rotations) {
    Connector& connector = world.connectors[span.connector];
    centre = &connector.position[end.particle];
    velocity = &connector.velocity[end.particle];
    if (end.kind == SpanEnd::Kind::particle) {
      inverse_mass = 1 / connector.particle_mass[end.particle];
    } else if (end.kind == SpanEnd::Kind::body) {
      body = &world.bodies[end.body];
      centre = &body->position;
      velocity = &body->velocity;
      inverse_mass = 1 / body->mass_properties.mass;
      inverse_inertia = rotations[end.body].inverse_inertia(body->rotation);
      arm = body->point(end.point) - body->position;
      spin = body->spin;
    }
  }

  /// The arm `ago` seconds before, to second order in the turn since.
  Vec3 arm_before(double ago) const {
    const Vec3 turn = ago * spin;
    return arm - turn.cross(arm) + turn.cross(turn.cross(arm)) / 2;
  }
  Vec3 point() const { return *centre + arm; }
  Vec3 point_before(double ago) const { return *centre - ago * *velocity + arm_before(ago); }
  Vec3 velocity_of(const Vec3& at) const { return *velocity + spin.cross(at); }

  /// The velocity that the point at `seen` gets from a unit impulse along `n` at `acting`.
  Vec3 answer(const Vec3& n, const Vec3& acting, const Vec3& seen) const {
    return inverse_mass * n + (inverse_inertia * acting.cross(n)).cross(seen);
  }
  /// The same as a matrix on the impulse.
  Mat3 answers(const Vec3& acting, const Vec3& seen) const {
    Mat3 matrix;
    for (int i = 0; i < 3; ++i) matrix.col(i) = answer(Vec3::Unit(i), acting, seen);
    return matrix;
  }

  void kick(const Vec3& impulse, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *velocity += inverse_mass * impulse;
    if (body) body->spin += inverse_inertia * acting.cross(impulse);
  }
  /// Moves it as far as an impulse would since it acted; `impulse_time` is the product, N s^2.
  void shift(const Vec3& impulse_time, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *centre += inverse_mass * impulse_time;
    if (!body) return;
    const Vec3 half = inverse_inertia * acting.cross(impulse_time) / 2;
    body->rotation = (Quat(1, half.x(), half.y(), half.z()) * body->rotation).normalized();
  }
};

/// The distances between which a span's ends are left alone, m. A span of several links folds.
struct Reach {
  double shortest, longest;
  double exact;  // so near a limit is at it

  Reach(const Span& span, const LinkLimits& limits)
      : shortest(span.links() == 1 ? limits.shortest * span.length : 0),
        longest(limits.longest * span.length),
        exact(kExact * span.length) {}
};

/// What the connector leaves of a rebound, m_a / (m_c + m_a); m_a is the reduced mass of both ends.
double mass_ratio(const Span& span, double inverse_mass) {
  return 1 / (1 + span.mass * inverse_mass);
}

/// A span without length is a joint: it holds in every direction. Half a step ago is when the
/// forces of a step act that keep it closed.
bool close_joint(const Side& a, const Side& b, double dt) {
  const Vec3 arm_a = a.arm_before(dt / 2), arm_b = b.arm_before(dt / 2);
  const Mat3 inverse = Mat3(a.answers(arm_a, a.arm) + b.answers(arm_b, b.arm)).inverse();
  const Vec3 shift = inverse * (a.point() - b.point());
  const Vec3 impulse = inverse * (a.velocity_of(a.arm) - b.velocity_of(b.arm));
  a.shift(-shift, arm_a);
  b.shift(shift, arm_b);
  a.kick(-impulse, arm_a);
  b.kick(impulse, arm_b);
  return true;
}

/// Equation (5) as it stands in the paper: each end answers as if the other were fixed, its moment
/// of inertia is a number (about the axis that resists most), and nothing clamps it. It has moved
/// with the mean of its velocities before and after. Returns the larger of the two impulses, N s.
double printed_impulse(const Side& a, const Side& b, const Span& span, const Vec3& along,
                       double parting, double elasticity, double dt) {
  double largest = 0;
  const auto apply = [&](const Side& side, const Vec3& toward_other) {
    if (side.inverse_mass == 0) return;
    double answer = side.inverse_mass;
    if (side.body) {
      const Mat3 inertia = side.body->mass_properties.inertia;
      const double moment = inertia.diagonal().maxCoeff();
      if (moment > 0) answer += side.arm.squaredNorm() / moment;
    }
    const double size = parting * (1 + elasticity) / answer * mass_ratio(span, side.inverse_mass);
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
  if (span.length == 0) return;
  if (!span.taut) {
    ++span.slack_steps;
    return;
  }
  const std::vector<Vec3>& position = world.connectors[span.connector].position;
  const double distance = (position[span.b.particle] - position[span.a.particle]).norm();
  const Reach reach(span, limits_);
  if (distance >= reach.longest - reach.exact || distance <= reach.shortest + reach.exact) return;
  span.taut = false;
  span.slack_steps = 1;
  events.push_back({Event::Kind::slack, time, span.connector, span.index, 0});
}

bool SpanImpulses::act(World& world, Span& span, double time, double dt,
                       std::vector<Event>& events) const {
  if (span.a.kind == SpanEnd::Kind::follower || span.b.kind == SpanEnd::Kind::follower) {
    return false;
  }
  const Side a(world, span, span.a, rotations_), b(world, span, span.b, rotations_);
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  if (inverse_mass == 0) return false;
  const auto log = [&](Event::Kind kind, double when, double size) {
    events.push_back({kind, when, span.connector, span.index, size});
  };
  const Vec3 gap = b.point() - a.point();
  const double distance = gap.norm();
  const Reach reach(span, limits_);
  const bool is_long = distance > reach.longest + reach.exact;
  if (!is_long && distance >= reach.shortest - reach.exact) return false;
  if (span.length == 0 && !as_printed_) return close_joint(a, b, dt);

  const Vec3 along = gap / distance;
  const double parting = along.dot(b.velocity_of(b.arm) - a.velocity_of(a.arm));
  const bool leaves = is_long ? parting > 0 : parting < 0;  // goes on leaving its limits
  const double elasticity = world.connectors[span.connector].elasticity;
  if (as_printed_) {
    if (!leaves) return false;
    const double size = printed_impulse(a, b, span, along, parting, elasticity, dt);
    if (!span.taut) {
      log(Event::Kind::taut, time, 0);
      log(Event::Kind::impulse, time, size);
    }
    span.taut = true;
    return false;  // both ends have answered; nothing more to settle in this step
  }

  // The span passed its limit `ago`; in steady tension that is half a step.
  const double limit = is_long ? reach.longest : reach.shortest;
  const double ago = leaves ? std::min((distance - limit) / parting, dt) : 0;
  const Vec3 arm_a = a.arm_before(ago), arm_b = b.arm_before(ago);
  const Vec3 line = (b.point_before(ago) - a.point_before(ago)).normalized();
  const Vec3 shift_answer = a.answer(line, arm_a, a.arm) + b.answer(line, arm_b, b.arm);
  // The shift along `line` that brings the ends back to their limit: |gap + shift answer| = limit.
  const double p = gap.dot(shift_answer), q = shift_answer.squaredNorm();
  const double excess = distance * distance - limit * limit;
  const double shift = -excess / (p + std::sqrt(std::max(0.0, p * p - q * excess)));

  double size = 0;
  double rebound = 0;
  if (leaves && !span.taut) {  // an impact: the law of restitution at the moment it happened
    if (span.slack_steps > kNoRebound) rebound = elasticity * mass_ratio(span, inverse_mass);
    const Vec3 answer = a.answer(line, arm_a, arm_a) + b.answer(line, arm_b, arm_b);
    const Vec3 relative = b.velocity_of(arm_b) - a.velocity_of(arm_a);
    size = -(1 + rebound) * line.dot(relative) / line.dot(answer);
    log(Event::Kind::taut, time - ago, 0);
    log(Event::Kind::impulse, time - ago, std::abs(size));
  } else if (leaves) {  // steady tension: the ends neither part nor approach when the step ends
    const Vec3 relative = b.velocity_of(b.arm) - a.velocity_of(a.arm);
    const Vec3 now = (gap + shift * shift_answer).normalized();
    size = -now.dot(relative) / now.dot(shift_answer);
  }
  span.taut = true;
  a.shift(-(1 + rebound) * shift * line, arm_a);
  b.shift((1 + rebound) * shift * line, arm_b);
  a.kick(-size * line, arm_a);
  b.kick(size * line, arm_b);
  return true;
}

}  // namespace taut
