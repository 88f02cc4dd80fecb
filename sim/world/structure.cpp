#include "sim/world/structure.h"

#include <memory>
#include <tuple>

#include "sim/motion/hash.h"

namespace taut {
namespace {

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

}  // namespace

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
  if (connector.applied_force) hash.text("applied force");
  if (connector.pulls) hash.text("pulls");
  if (connector.links_touch) hash.text("links touch");
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

std::uint64_t structure_of_bead_pair(const World& world, std::size_t index) {
  const BeadPair& pair = world.bead_pairs[index];
  Hash hash;
  hash.text("beads").word(index).word(pair.connector).word(pair.body);
  hash.word(pair.static_friction).word(pair.kinetic_friction).word(pair.restitution);
  return hash.value();
}

std::uint64_t structure_of_connector_pair(const World& world, std::size_t index) {
  const ConnectorPair& pair = world.connector_pairs[index];
  Hash hash;
  hash.text("connectors").word(index).word(pair.a).word(pair.b);
  hash.word(pair.static_friction).word(pair.kinetic_friction).word(pair.restitution);
  return hash.value();
}

std::uint64_t structure(const World& world) {
  std::uint64_t sum = 0;
  for (std::size_t p = 0; p < world.connector_pairs.size(); ++p) {
    sum += structure_of_connector_pair(world, p);
  }
  for (std::size_t p = 0; p < world.bead_pairs.size(); ++p) sum += structure_of_bead_pair(world, p);
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

}  // namespace taut
