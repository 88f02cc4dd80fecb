#include "tests/bench/promise/shapes.h"

#include <algorithm>
#include <cmath>

namespace taut::promise {

Vec3 from_down(double tilt, double azimuth) {
  return {std::sin(tilt) * std::cos(azimuth), -std::cos(tilt), std::sin(tilt) * std::sin(azimuth)};
}

Directions straight(std::size_t links, const Vec3& along) {
  return Directions(links, along);
}

Directions zigzag(std::size_t links, std::size_t pieces, const Vec3& along, double angle) {
  const Vec3 across = along.unitOrthogonal();
  Directions directions(links);
  for (std::size_t k = 0; k < links; ++k) {
    const bool other = k * std::min(pieces, links) / links % 2 == 1;
    directions[k] = std::cos(angle) * along + (other ? -1 : 1) * std::sin(angle) * across;
  }
  return directions;
}

Directions bent(std::size_t links, const Vec3& along, double turn, double twist) {
  const Vec3 axis = along.unitOrthogonal();
  Directions directions(links);
  Vec3 direction = along;
  for (std::size_t k = 0; k < links; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(links);
    const Vec3 about = Eigen::AngleAxisd(share * twist, along) * axis;
    direction = Eigen::AngleAxisd(turn / static_cast<double>(links), about) * direction;
    directions[k] = direction;
  }
  return directions;
}

Connector shaped(const char* name, double length, double mass, const Vec3& start,
                 const Directions& directions) {
  Connector connector =
      straight_connector(name, length, mass, directions.size() + 1, start, directions[0]);
  for (std::size_t k = 0; k < directions.size(); ++k) {
    connector.position[k + 1] = connector.position[k] + connector.rest[k] * directions[k];
  }
  return connector;
}

void move(Connector& connector, std::size_t first, const Vec3& about, const Vec3& velocity,
          const Vec3& spin) {
  for (std::size_t i = first; i < connector.particles(); ++i) {
    connector.velocity[i] = velocity + spin.cross(connector.position[i] - about);
  }
}

}  // namespace taut::promise
