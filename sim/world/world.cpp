#include "sim/world/world.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/world/ties.h"
#include "sim/world/twist.h"
#include "sim/world/winched.h"

namespace taut {
namespace {

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

/// The flaw of a body that is to touch others, or empty.
std::string body_flaw(const World& world, std::size_t index) {
  if (index >= world.bodies.size()) return "a pair is of a body that is not there";
  const Body& body = world.bodies[index];
  if (body.driven()) return "a pair is of the body " + body.name + ", which is driven";
  if (body.capsule.touches()) return {};
  return "a pair is of the body " + body.name + ", which touches nothing";
}

/// Numbers the places of ends that have no number yet (Connector::end_place).
void number_end_places(World& world) {
  std::map<std::array<double, 3>, std::uint32_t> number;
  for (Connector& connector : world.connectors) {
    for (const std::size_t end : {0u, 1u}) {
      if (connector.end_place[end] != 0 || connector.position.empty()) continue;
      const Vec3& at = end == 0 ? connector.position.front() : connector.position.back();
      const auto [place, is_new] = number.emplace(std::array{at.x(), at.y(), at.z()}, 0);
      if (is_new) place->second = ++world.end_places;
      connector.end_place[end] = place->second;
    }
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
  number_end_places(world);
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
  number_end_places(world);
  world.topology = structure(world);
}

std::string pair_flaw(const World& world) {
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const BodyPair& pair : world.pairs) {
    for (const std::size_t b : {pair.a, pair.b}) {
      if (std::string flaw = body_flaw(world, b); !flaw.empty()) return flaw;
    }
    const std::string& name = world.bodies[pair.a].name;
    if (pair.a == pair.b) return "a pair is of the body " + name + " and itself";
    if (seen.insert(std::minmax(pair.a, pair.b)).second) continue;
    return "there are two pairs of the bodies " + name + " and " + world.bodies[pair.b].name;
  }
  seen.clear();
  for (const BeadPair& pair : world.bead_pairs) {
    if (pair.connector >= world.connectors.size()) return "a pair is of no connector";
    if (std::string flaw = body_flaw(world, pair.body); !flaw.empty()) return flaw;
    if (seen.insert({pair.connector, pair.body}).second) continue;
    return "there are two pairs of the connector " + world.connectors[pair.connector].name +
           " and the body " + world.bodies[pair.body].name;
  }
  seen.clear();
  for (const ConnectorPair& pair : world.connector_pairs) {
    for (const std::size_t c : {pair.a, pair.b}) {
      if (c >= world.connectors.size()) return "a pair is of no connector";
      const Connector& connector = world.connectors[c];
      if (connector.model == ConnectorModel::span) {
        return "a pair is of the connector " + connector.name + ", a massless span";
      }
      if (!(connector.radius > 0)) {
        return "a pair is of the connector " + connector.name + ", which has no radius";
      }
    }
    if (seen.insert(std::minmax(pair.a, pair.b)).second) continue;
    return "there are two pairs of the connectors " + world.connectors[pair.a].name + " and " +
           world.connectors[pair.b].name;
  }
  return {};
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
