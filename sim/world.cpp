#include "sim/world.h"

namespace taut {
namespace {

/// Joins a point mass to a free body without moving the body's frame or any of its points.
void join_mass(Body& body, double mass, const Vec3& point) {
  const MassProperties joined = with_point_mass(body.mass_properties, mass, point);
  body.velocity = body.point_velocity(joined.centre);
  body.position = body.point(joined.centre);
  body.mass_properties = joined;
}

}  // namespace

void finish(World& world) {
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      if (hold.to.kind != Attachment::Kind::body) continue;
      Body& body = world.bodies[hold.to.body];
      if (!body.driven()) join_mass(body, connector.particle_mass[hold.particle], hold.to.point);
    }
  }
  place_held(world, world.time);
}

PointMotion hold_motion(const World& world, const Attachment& to, double time) {
  switch (to.kind) {
    case Attachment::Kind::fixed:
      break;
    case Attachment::Kind::path:
      return to.path->at(time).point(to.point);
    case Attachment::Kind::body: {
      const Body& body = world.bodies[to.body];
      if (body.driven()) return driven_frame(body, time).point(to.point);
      return {body.point(to.point), body.point_velocity(to.point), Vec3::Zero()};
    }
  }
  return {to.point, Vec3::Zero(), Vec3::Zero()};
}

bool is_prescribed(const World& world, const Attachment& to) {
  return to.kind != Attachment::Kind::body || world.bodies[to.body].driven();
}

void place_held(World& world, double time) {
  world.time = time;
  for (Body& body : world.bodies) {
    if (!body.driven()) continue;
    const FrameMotion frame = driven_frame(body, time);
    const PointMotion centre = frame.point(body.mass_properties.centre);
    body.position = centre.position;
    body.velocity = centre.velocity;
    body.rotation = frame.rotation;
    body.spin = frame.spin;
  }
  for (Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      PointMotion motion;
      if (hold.to.kind == Attachment::Kind::body) {  // driven bodies have just been placed
        const Body& body = world.bodies[hold.to.body];
        motion = {body.point(hold.to.point), body.point_velocity(hold.to.point), Vec3::Zero()};
      } else {
        motion = hold_motion(world, hold.to, time);
      }
      connector.position[hold.particle] = motion.position;
      connector.velocity[hold.particle] = motion.velocity;
    }
  }
}

}  // namespace taut
