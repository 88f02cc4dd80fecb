#include "sim/world/connector.h"

#include <cmath>
#include <stdexcept>

namespace taut {

Connector straight_connector(std::string name, double length, double mass, std::size_t particles,
                             const Vec3& start, const Vec3& direction) {
  if (particles < 2) throw std::invalid_argument("a connector needs at least 2 particles");
  if (!(length >= 0)) throw std::invalid_argument("a connector's length cannot be negative");
  if (!(mass >= 0)) throw std::invalid_argument("a connector's mass cannot be negative");
  if (length > 0 && !(direction.norm() > 0)) {
    throw std::invalid_argument("a connector's direction cannot be zero");
  }
  Connector connector;
  connector.name = std::move(name);
  connector.length = length;
  connector.mass = mass;
  connector.rest.assign(particles - 1, length / static_cast<double>(particles - 1));
  connector.particle_mass.assign(particles, mass / static_cast<double>(particles));
  connector.velocity.assign(particles, Vec3::Zero());
  connector.position.resize(particles);
  const Vec3 unit = direction.stableNormalized();
  for (std::size_t i = 0; i < particles; ++i) {
    const double along = length * static_cast<double>(i) / static_cast<double>(particles - 1);
    connector.position[i] = start + along * unit;
  }
  return connector;
}

void weigh_by_links(Connector& connector) {
  const double each = connector.mass / static_cast<double>(connector.particles());
  for (double& mass : connector.particle_mass) mass -= each;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double half = connector.mass / static_cast<double>(connector.links()) / 2;
    connector.particle_mass[k] += half;
    connector.particle_mass[k + 1] += half;
  }
}

}  // namespace taut
