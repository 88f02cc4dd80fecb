// The impulses between the ends of a span whose pull goes around corners.
#include <algorithm>
#include <cmath>

#include "sim/methods/span_impulse.h"
#include "sim/methods/span_side.h"

namespace taut::methods {
namespace {

constexpr double kSlack = 1e-6;  // of its length: a part that is so much shorter does not pull
constexpr double kMostGone = 2;  // of what a way may have got longer in a step by its rate
constexpr int kNewton = 4;       // steps, each of which doubles the digits

/// An end of such a span, and the corner before it.
struct Leg {
  Side side;
  const SpanPath::Corner& corner;
  Vec3 way, toward;  // m, to the corner; the unit vector

  Leg(World& world, const Span& span, const SpanEnd& end, const SpanPath::Corner& at,
      const std::vector<FreeRotation>& rotations)
      : side(world, span, end, rotations), corner(at), way(at.at - side.point()) {
    toward = direction(way);
  }
  static Vec3 direction(const Vec3& way) {
    const double length = way.norm();
    return length > 0 ? Vec3(way / length) : Vec3(0, 0, 0);
  }
  /// m/s, at which it gets longer where the corner moves with `velocity`.
  double rate(const Vec3& velocity) const {
    return toward.dot(velocity - side.velocity_of(side.arm));
  }
  double mobility() const {
    return toward.dot(side.inverse_mass_along(toward, side.arm, side.arm));
  }
  /// N s: the pull that keeps it from getting longer, by itself.
  double pull() const {
    const double speed = rate(corner.carried), mobile = mobility();
    if (speed <= 0) return 0;
    return mobile > 0 ? speed / mobile : HUGE_VAL;
  }
};

}  // namespace

SpanPath::State SpanImpulses::grip(World& world, const Span& span, const SpanPath& path) const {
  using enum SpanPath::State;
  if (as_printed_) return held;
  const Leg a(world, span, span.a, path.first, rotations_),
      b(world, span, span.b, path.last, rotations_);
  // A taut way pulls at both ends, wherever its beads are on it; of a slack one only what friction
  // at the corners keeps taut by itself.
  const double taut = limits_.longest - kSlack;
  const bool is_taut = a.way.norm() + path.inner + b.way.norm() >= taut * span.length;
  const double at_a = is_taut || a.way.norm() >= taut * path.first_length ? a.pull() : 0;
  const double at_b = is_taut || b.way.norm() >= taut * path.last_length ? b.pull() : 0;
  if (at_a == 0 && at_b == 0) return slack;
  if (at_b > path.most_stuck * at_a) return slides_to_b;
  if (at_a > path.most_stuck * at_b) return slides_to_a;
  return held;
}

void SpanImpulses::watch_around(const World& world, Span& span, const SpanPath& path, double time,
                                std::vector<Event>& events) const {
  if (!span.taut) return;
  const std::vector<Vec3>& position = world.connectors[span.connector].position;
  const double length = (path.first.at - position[span.a.particle]).norm() + path.inner +
                        (position[span.b.particle] - path.last.at).norm();
  if (length >= (limits_.longest - kSlack) * span.length) return;
  span.taut = false;
  events.push_back({Event::Kind::slack, time, span.connector, span.index, 0});
}

bool SpanImpulses::act_around(World& world, Span& span, const SpanPath& path, double time,
                              double dt, std::vector<Event>& events) const {
  if (span.a.kind == SpanEnd::Kind::follower || span.b.kind == SpanEnd::Kind::follower) {
    return false;
  }
  const Leg a(world, span, span.a, path.first, rotations_),
      b(world, span, span.b, path.last, rotations_);
  if (a.side.inverse_mass + b.side.inverse_mass == 0) return false;
  const double reach = a.way.norm() + path.inner + b.way.norm();
  double excess = reach - limits_.longest * span.length;
  if (excess <= kAtLimit * span.length) return false;
  const double pull_a = path.state == SpanPath::State::slides_to_a ? path.most_slid : 1;
  const double pull_b = path.state == SpanPath::State::slides_to_b ? path.most_slid : 1;

  const double separation_speed = a.rate(path.first.led) + path.inner_rate + b.rate(path.last.led);
  if (separation_speed <= 0) return false;
  // What beads in a heap make the way longer by is not what the ends have gone.
  excess = std::min(excess, kMostGone * dt * separation_speed);
  const bool impact = !span.taut;
  const double fall =
      -a.toward.dot(a.side.fall(world.gravity)) - b.toward.dot(b.side.fall(world.gravity));
  double ago = std::min(excess / separation_speed, dt);
  if (impact) {
    const double speed = std::max(separation_speed - fall * ago / 2, separation_speed / 2);
    ago = std::min(excess / speed, dt);
  }
  // At the moment at which the path had its length, as for a span without corners.
  const Vec3 line_a =
      Leg::direction(path.first.at - ago * path.first.led - a.side.point_before(ago));
  const Vec3 line_b = Leg::direction(path.last.at - ago * path.last.led - b.side.point_before(ago));
  const Vec3 arm_a = a.side.arm_before(ago), arm_b = b.side.arm_before(ago);
  const Vec3 response_a = pull_a * a.side.inverse_mass_along(line_a, arm_a, a.side.arm);
  const Vec3 response_b = pull_b * b.side.inverse_mass_along(line_b, arm_b, b.side.arm);
  double shift = 0;  // N s^2
  Vec3 now_a = a.toward, now_b = b.toward;
  for (int i = 0; i < kNewton; ++i) {
    const Vec3 way_a = a.way - shift * response_a, way_b = b.way - shift * response_b;
    now_a = Leg::direction(way_a);
    now_b = Leg::direction(way_b);
    const double shortens = now_a.dot(response_a) + now_b.dot(response_b);
    if (!(shortens > 0)) return false;
    shift += (way_a.norm() + path.inner + way_b.norm() - (reach - excess)) / shortens;
  }
  double size = 0;  // N s
  if (impact) {
    const double then = pull_a * line_a.dot(a.side.inverse_mass_along(line_a, arm_a, arm_a)) +
                        pull_b * line_b.dot(b.side.inverse_mass_along(line_b, arm_b, arm_b));
    const double speed = line_a.dot(path.first.led - a.side.velocity_of(arm_a)) + path.inner_rate +
                         line_b.dot(path.last.led - b.side.velocity_of(arm_b));
    const double ratio = mass_ratio(span, a.side.inverse_mass + b.side.inverse_mass);
    const double back = world.connectors[span.connector].restitution * ratio * (speed - fall * ago);
    const bool rebounds = back > fall * ago;
    size = (speed - (rebounds ? fall * ago - back : 0)) / then;
    if (rebounds) shift += ago * (back - fall * ago / 2) / then;
    events.push_back({Event::Kind::taut, time - ago, span.connector, span.index, 0});
    events.push_back(
        {Event::Kind::impulse, time - ago, span.connector, span.index, std::abs(size)});
  } else {
    const double rate = now_a.dot(path.first.led - a.side.velocity_of(a.side.arm)) +
                        path.inner_rate + now_b.dot(path.last.led - b.side.velocity_of(b.side.arm));
    size = rate / (now_a.dot(response_a) + now_b.dot(response_b));
  }
  span.taut = true;
  a.side.kick(pull_a * size * line_a, arm_a);
  b.side.kick(pull_b * size * line_b, arm_b);
  a.side.shift(pull_a * shift * line_a, arm_a);
  b.side.shift(pull_b * shift * line_b, arm_b);
  return true;
}

}  // namespace taut::methods
