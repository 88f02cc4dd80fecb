#include "sim/world/held.h"

#include <algorithm>

namespace taut {
namespace {

/// Adds what is left of a hold's approach: a smoothstep from `lag` to nothing, of fifth order.
void approach(const Attachment::Approach& approach, double time, PointMotion& motion) {
  if (time >= approach.arrival) return;
  const double span = approach.arrival - approach.since;
  const double u = std::max(0.0, (time - approach.since) / span);
  motion.position += (1 - u * u * u * (10 - 15 * u + 6 * u * u)) * approach.lag;
  motion.velocity -= 30 * u * u * (1 - u) * (1 - u) / span * approach.lag;
  motion.acceleration -= 60 * u * (1 - u) * (1 - 2 * u) / (span * span) * approach.lag;
}

}  // namespace

PointMotion hold_motion(const World& world, const Attachment& to, double time) {
  PointMotion motion{to.point, Vec3::Zero(), Vec3::Zero()};
  if (to.kind == Attachment::Kind::path) {
    motion = to.path->at(time).point(to.point);
  } else if (to.kind == Attachment::Kind::body) {
    const Body& body = world.bodies[to.body];
    if (!body.driven()) return {body.point(to.point), body.point_velocity(to.point), Vec3::Zero()};
    motion = driven_frame(body, time).point(to.point);
  }
  approach(to.approach, time, motion);
  return motion;
}

bool is_prescribed(const World& world, const Attachment& to) {
  return to.kind != Attachment::Kind::body || world.bodies[to.body].driven();
}

ClampMotion clamp_motion(const World& world, const Hold& hold, double time) {
  if (hold.clamp.isZero(0)) return {};
  const Vec3 own = hold.clamp.normalized();
  const Attachment& to = hold.to;
  if (to.kind == Attachment::Kind::fixed) return {own, Vec3::Zero()};
  if (to.kind == Attachment::Kind::body && !world.bodies[to.body].driven()) {
    const Body& body = world.bodies[to.body];
    const Vec3 direction = body.rotation * own;
    return {direction, body.spin.cross(direction)};
  }
  const FrameMotion frame = to.kind == Attachment::Kind::path
                                ? to.path->at(time)
                                : driven_frame(world.bodies[to.body], time);
  const Vec3 direction = frame.rotation * own;
  return {direction, frame.spin.cross(direction)};
}

void place_hold(const World& world, Connector& connector, const Hold& hold) {
  PointMotion motion;
  if (hold.to.kind == Attachment::Kind::body) {
    const Body& body = world.bodies[hold.to.body];
    if (!body.driven()) return;
    motion = {body.point(hold.to.point), body.point_velocity(hold.to.point), Vec3::Zero()};
    approach(hold.to.approach, world.time, motion);
  } else {
    motion = hold_motion(world, hold.to, world.time);
  }
  connector.position[hold.particle] = motion.position;
  connector.velocity[hold.particle] = motion.velocity;
}

}  // namespace taut
