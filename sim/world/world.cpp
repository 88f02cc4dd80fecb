#include "sim/world/world.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "sim/motion/hash.h"

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

void add_materials(const World& world, Hash& hash) {
  const auto add = [&](const Vec3& vector) {
    for (const double c : vector) hash.word(c);
  };
  hash.word(world.air.density);
  add(world.air.wind);
  for (const Connector& connector : world.connectors) {
    hash.word(connector.sections.size());
    hash.word(connector.drag.across).word(connector.drag.along);
    for (const Hold& hold : connector.holds) add(hold.clamp);
    for (const Section& section : connector.sections) {
      hash.word(section.axial_stiffness).word(section.axial_damping);
      hash.word(section.bending_stiffness).word(section.bending_damping).word(section.diameter);
    }
  }
}

}  // namespace

MassProperties laden(const World& world, std::size_t body) {
  MassProperties properties = world.bodies[body].bare;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::body || hold.to.body != body) continue;
      const double mass = joined_mass(world, c, hold.particle);
      properties = with_point_mass(properties, mass, hold.to.point);
    }
  }
  return properties;
}

void reweigh_holder(World& world, const Attachment& by) {
  if (!is_prescribed(world, by)) reweigh(world.bodies[by.body], laden(world, by.body));
}

namespace {

/// The mass properties of every body, as laden() adds them up.
std::vector<MassProperties> all_laden(const World& world) {
  std::vector<MassProperties> laden;
  for (const Body& body : world.bodies) laden.push_back(body.bare);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::body) continue;
      MassProperties& properties = laden[hold.to.body];
      const double mass = joined_mass(world, c, hold.particle);
      properties = with_point_mass(properties, mass, hold.to.point);
    }
  }
  return laden;
}

}  // namespace

void finish(World& world) {
  if (const std::string flaw = joint_flaw(world); !flaw.empty()) throw std::invalid_argument(flaw);
  for (Body& body : world.bodies) body.bare = body.mass_properties;
  const std::vector<MassProperties> laden = all_laden(world);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (!world.bodies[i].driven()) reweigh(world.bodies[i], laden[i]);
  }
  place_held(world, world.time);
  world.topology = structure(world);
}

void refresh(World& world) {
  if (structure(world) == world.topology) return;
  if (const std::string flaw = joint_flaw(world); !flaw.empty()) throw std::invalid_argument(flaw);
  for (Body& body : world.bodies) {
    if (body.bare.mass == 0) body.bare = body.mass_properties;  // it is new
  }
  const std::vector<MassProperties> laden = all_laden(world);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (!world.bodies[i].driven()) reweigh(world.bodies[i], laden[i]);
  }
  place_held(world, world.time);
  world.topology = structure(world);
}

bool has_materials(const World& world) {
  return std::ranges::any_of(
      world.connectors, [](const Connector& connector) { return !connector.sections.empty(); });
}

std::uint64_t structure(const World& world) {
  Hash hash;
  const auto add = [&](const Vec3& vector) {
    for (const double c : vector) hash.word(c);
  };
  const auto add_path = [&](const std::shared_ptr<const Path>& path) {
    hash.word(path ? path->fingerprint() : 0);
  };
  for (const Body& body : world.bodies) {
    const MassProperties& properties = body.mass_properties;
    hash.word(properties.mass);
    add(properties.centre);
    for (const double moment : properties.inertia.reshaped()) hash.word(moment);
    hash.word(body.bare.mass);
    add(body.bare.centre);
    for (const double moment : body.bare.inertia.reshaped()) hash.word(moment);
    add_path(body.path);
    add(body.grip);
  }
  for (const Connector& connector : world.connectors) {
    hash.word(connector.particles()).word(static_cast<std::uint64_t>(connector.model));
    hash.word(connector.restitution);
    for (const double rest : connector.rest) hash.word(rest);
    for (const double mass : connector.particle_mass) hash.word(mass);
    hash.word(connector.holds.size());
    for (const Hold& hold : connector.holds) {
      const Attachment& to = hold.to;
      hash.word(hold.particle).word(hold.pin.number);
      hash.word(static_cast<std::uint64_t>(to.kind));
      hash.word(to.kind == Attachment::Kind::body ? to.body : 0);
      add_path(to.path);
      add(to.point);
      add(to.approach.lag);
      hash.word(to.approach.since).word(to.approach.arrival);
    }
  }
  if (has_materials(world)) add_materials(world, hash);
  for (const Joint& joint : world.joints) {
    hash.word(joint.particles.size());
    for (const Joint::Particle& at : joint.particles) hash.word(at.connector).word(at.particle);
  }
  if (world.obstacles.empty()) return hash.value();
  for (const Connector& connector : world.connectors) hash.word(connector.radius);
  for (const Obstacle& obstacle : world.obstacles) hash.word(fingerprint(obstacle));
  return hash.value();
}

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

void place_held(World& world, double time) {
  place_prescribed(world, time);
  place_carried(world);
  place_joined(world);
}

void place_prescribed(World& world, double time) {
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
      if (hold.to.kind == Attachment::Kind::body) {
        const Body& body = world.bodies[hold.to.body];
        if (!body.driven()) continue;
        // It has just been placed.
        motion = {body.point(hold.to.point), body.point_velocity(hold.to.point), Vec3::Zero()};
        approach(hold.to.approach, time, motion);
      } else {
        motion = hold_motion(world, hold.to, time);
      }
      connector.position[hold.particle] = motion.position;
      connector.velocity[hold.particle] = motion.velocity;
    }
  }
}

void place_carried(World& world) {
  for (Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      if (is_prescribed(world, hold.to)) continue;
      const Body& body = world.bodies[hold.to.body];
      connector.position[hold.particle] = body.point(hold.to.point);
      connector.velocity[hold.particle] = body.point_velocity(hold.to.point);
    }
  }
}

}  // namespace taut
