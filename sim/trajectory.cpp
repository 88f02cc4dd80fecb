#include "sim/trajectory.h"

#include <bit>

namespace taut {
namespace {

class Fnv1a {
 public:
  void add(double value) {
    auto bits = std::bit_cast<std::uint64_t>(value);
    for (int byte = 0; byte < 8; ++byte, bits >>= 8) {
      hash_ = (hash_ ^ (bits & 0xff)) * 0x100000001b3ULL;
    }
  }
  void add(const Vec3& v) {
    for (const double c : v) add(c);
  }
  void add(const Quat& q) {
    for (const double c : q.coeffs()) add(c);
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

}  // namespace

Snapshot snapshot(const World& world) {
  Snapshot shot;
  shot.time = world.time;
  shot.connectors.reserve(world.connectors.size());
  for (const Connector& connector : world.connectors) shot.connectors.push_back(connector.position);
  shot.bodies.reserve(world.bodies.size());
  for (const Body& body : world.bodies) shot.bodies.push_back(body.frame());
  return shot;
}

std::uint64_t state_hash(const World& world) {
  Fnv1a hash;
  hash.add(world.time);
  for (const Body& body : world.bodies) {
    hash.add(body.position);
    hash.add(body.rotation);
    hash.add(body.velocity);
    hash.add(body.spin);
  }
  for (const Connector& connector : world.connectors) {
    for (const Vec3& position : connector.position) hash.add(position);
    for (const Vec3& velocity : connector.velocity) hash.add(velocity);
  }
  return hash.hash();
}

}  // namespace taut
