#include "sim/world/world.h"

#include <algorithm>
#include <memory>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "sim/motion/hash.h"
#include "sim/world/ties.h"
#include "sim/world/twist.h"
#include "sim/world/winched.h"

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

void add(const Vec3& vector, Hash& hash) {
  for (const double c : vector) hash.word(c);
}

void add(const MassProperties& properties, Hash& hash) {
  hash.word(properties.mass);
  add(properties.centre, hash);
  for (const double moment : properties.inertia.reshaped()) hash.word(moment);
}

void add(const std::shared_ptr<const Path>& path, Hash& hash) {
  hash.word(path ? path->fingerprint() : 0);
}

void add_materials(const Connector& connector, Hash& hash) {
  hash.word(connector.drag.across).word(connector.drag.along);
  for (const Hold& hold : connector.holds) {
    add(hold.clamp, hash);
    if (hold.turn) add(hold.turn, hash);
  }
  for (const Section& section : connector.sections) {
    hash.word(section.axial_stiffness).word(section.axial_damping);
    hash.word(section.bending_stiffness).word(section.bending_damping).word(section.diameter);
    if (!section.rest_curvature.isZero(0)) add(section.rest_curvature, hash);
    if (section.twisting_stiffness == 0) continue;
    hash.word(section.twisting_stiffness).word(section.twisting_damping).word(section.rest_twist);
  }
}

/// The mass properties of every body, with the particles that it holds.
std::vector<MassProperties> all_laden(const World& world) {
  Ties ties;
  if (!world.joints.empty()) ties.follow(world);
  std::vector<MassProperties> laden;
  for (const Body& body : world.bodies) laden.push_back(body.bare);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::body) continue;
      MassProperties& properties = laden[hold.to.body];
      const double mass = world.joints.empty() ? world.connectors[c].particle_mass[hold.particle]
                                               : ties.joined_mass(world, c, hold.particle);
      properties = with_point_mass(properties, mass, hold.to.point);
    }
  }
  return laden;
}

void refuse_flaws(const World& world) {
  for (const std::string& flaw : {joint_flaw(world), pair_flaw(world), winch_flaw(world)}) {
    if (!flaw.empty()) throw std::invalid_argument(flaw);
  }
}

}  // namespace

void reweigh(World& world) {
  const std::vector<MassProperties> laden = all_laden(world);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    if (!world.bodies[i].driven()) reweigh(world.bodies[i], laden[i]);
  }
}

void finish(World& world) {
  refuse_flaws(world);
  for (Body& body : world.bodies) body.bare = body.mass_properties;
  reweigh(world);
  place_held(world, world.time);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (carries_twist(world, c)) world.connectors[c].end_turn = {.start = end_turn(world, c)};
  }
  world.topology = structure(world);
}

void refresh(World& world) {
  if (structure(world) == world.topology) return;
  refuse_flaws(world);
  for (Body& body : world.bodies) {
    if (body.bare.mass == 0) body.bare = body.mass_properties;  // it is new
  }
  reweigh(world);
  place_held(world, world.time);
  world.topology = structure(world);
}

bool has_materials(const World& world) {
  return std::ranges::any_of(
      world.connectors, [](const Connector& connector) { return !connector.sections.empty(); });
}

bool has_strings(const World& world) {
  return std::ranges::any_of(world.connectors, &Connector::pulls);
}

bool has_winches(const World& world) {
  return std::ranges::any_of(world.connectors,
                             [](const Connector& connector) { return connector.winch != nullptr; });
}

std::string pair_flaw(const World& world) {
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const BodyPair& pair : world.pairs) {
    for (const std::size_t b : {pair.a, pair.b}) {
      if (b >= world.bodies.size()) return "a pair is of a body that is not there";
      const Body& body = world.bodies[b];
      if (body.driven()) return "a pair is of the body " + body.name + ", which is driven";
      if (!body.capsule.touches()) {
        return "a pair is of the body " + body.name + ", which touches nothing";
      }
    }
    const std::string& name = world.bodies[pair.a].name;
    if (pair.a == pair.b) return "a pair is of the body " + name + " and itself";
    if (seen.insert(std::minmax(pair.a, pair.b)).second) continue;
    return "there are two pairs of the bodies " + name + " and " + world.bodies[pair.b].name;
  }
  return {};
}

bool has_touching_bodies(const World& world) {
  if (!world.pairs.empty()) return true;
  return !world.obstacles.empty() && std::ranges::any_of(world.bodies, [](const Body& body) {
    return body.capsule.touches() && !body.driven();
  });
}

bool has_contact(const World& world) {
  return !world.obstacles.empty() || !world.pairs.empty();
}

std::uint64_t structure_of_body(const World& world, std::size_t index) {
  const Body& body = world.bodies[index];
  Hash hash;
  hash.text("body").word(index);
  add(body.mass_properties, hash);
  add(body.bare, hash);
  add(body.path, hash);
  add(body.grip, hash);
  if (body.capsule.touches()) {
    hash.word(body.capsule.radius);
    add(body.capsule.from, hash);
    add(body.capsule.to, hash);
    if (body.capsule.category != 0) hash.word(body.capsule.category);
  }
  return hash.value();
}

std::uint64_t structure_of_connector(const World& world, std::size_t index) {
  const Connector& connector = world.connectors[index];
  Hash hash;
  hash.text("connector").word(index);
  hash.word(connector.particles()).word(static_cast<std::uint64_t>(connector.model));
  hash.word(connector.restitution).word(connector.radius);
  // Sums of short hashes, none of which waits for another.
  std::uint64_t sum = 0;
  const auto& [rests, masses] =
      connector.winch ? std::tie(connector.winch->rest, connector.winch->particle_mass)
                      : std::tie(connector.rest, connector.particle_mass);
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    const double rest = i < connector.links() ? rests[i] : 0;
    sum += Hash().word(i).word(rest).word(masses[i]).value();
  }
  hash.word(sum).word(connector.holds.size());
  sum = 0;
  for (const Hold& hold : connector.holds) {
    const Attachment& to = hold.to;
    Hash own;
    own.word(hold.particle).word(hold.pin.number);
    own.word(static_cast<std::uint64_t>(to.kind));
    own.word(to.kind == Attachment::Kind::body ? to.body : 0);
    add(to.path, own);
    add(to.point, own);
    add(to.approach.lag, own);
    sum += own.word(to.approach.since).word(to.approach.arrival).value();
  }
  hash.word(sum);
  if (!connector.sections.empty()) add_materials(connector, hash);
  if (connector.pulls) hash.text("pulls");
  if (connector.winch) {
    for (const auto& path : connector.winch->paths) add(path, hash);
    hash.word(connector.winch->density);
    for (const double share : connector.winch->before) hash.word(share);
  }
  if (connector.category != 0) hash.word(connector.category);
  return hash.value();
}

std::uint64_t structure_of_joint(const World& world, std::size_t index) {
  Hash hash;
  hash.text("joint").word(index);
  for (const Joint::Particle& at : world.joints[index].particles) {
    hash.word(at.connector).word(at.particle);
  }
  return hash.value();
}

std::uint64_t structure(const World& world) {
  std::uint64_t sum = 0;
  for (std::size_t j = 0; j < world.joints.size(); ++j) sum += structure_of_joint(world, j);
  for (std::size_t b = 0; b < world.bodies.size(); ++b) sum += structure_of_body(world, b);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) sum += structure_of_connector(world, c);
  Hash hash;
  if (has_materials(world)) {
    hash.word(world.air.density);
    add(world.air.wind, hash);
    if (world.air.gusts) hash.word(world.air.gusts->fingerprint());
  }
  for (const Obstacle& obstacle : world.obstacles) hash.word(fingerprint(obstacle));
  for (const Pulley& pulley : world.pulleys) {
    hash.text("pulley").word(pulley.from).word(pulley.to).word(pulley.inertia);
    hash.word(pulley.friction).word(pulley.bearing);
  }
  for (const BodyPair& pair : world.pairs) {
    hash.word(pair.a).word(pair.b).word(pair.static_friction).word(pair.kinetic_friction);
    hash.word(pair.restitution);
  }
  return sum + hash.value();
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
  place_driven(world, time);
  for (Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) place_hold(world, connector, hold);
  }
}

void place_driven(World& world, double time) {
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
  set_lengths(world, time);
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
