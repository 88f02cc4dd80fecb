#include "sim/run/trajectory.h"

#include "sim/motion/hash.h"

namespace taut {
namespace {

void add(Hash& hash, const Vec3& v) {
  hash.number(v.x()).number(v.y()).number(v.z());
}

}  // namespace

Snapshot snapshot(const World& world) {
  Snapshot shot;
  shot.time = world.time;
  shot.connectors.reserve(world.connectors.size());
  for (const Connector& connector : world.connectors) shot.connectors.push_back(connector.position);
  shot.bodies.reserve(world.bodies.size());
  for (const Body& body : world.bodies) shot.bodies.push_back(body.frame());
  for (const Pulley& pulley : world.pulleys) shot.passed.push_back(pulley.passed);
  return shot;
}

std::uint64_t state_hash(const World& world) {
  Hash hash;
  hash.number(world.time);
  for (const Body& body : world.bodies) {
    add(hash, body.position);
    for (const double c : body.rotation.coeffs()) hash.number(c);
    add(hash, body.velocity);
    add(hash, body.spin);
  }
  for (const Connector& connector : world.connectors) {
    for (const Vec3& position : connector.position) add(hash, position);
    for (const Vec3& velocity : connector.velocity) add(hash, velocity);
  }
  for (const Pulley& pulley : world.pulleys) hash.number(pulley.passed).number(pulley.speed);
  return hash.value();
}

}  // namespace taut
