#include "sim/reference/sdfast/pin.h"

#include <cmath>
#include <utility>

namespace taut::sdfast {

std::optional<Plane> plane_of(const World& world, const Chain& chain) {
  if (!chain.held || chain.held->kind != Attachment::Kind::fixed || chain.tip) return {};
  const Connector& connector = world.connectors.front();
  std::vector<Vec3> vectors{world.gravity};
  for (std::size_t k = 0; k < connector.links(); ++k) {
    vectors.push_back(connector.position[k + 1] - connector.position[k]);
    vectors.push_back(connector.velocity[k + 1] - connector.velocity[k]);
  }
  return common_plane(vectors, {});
}

void set_up_pins(const Model& model, const World& world, const Chain& chain, const Plane& plane) {
  const Connector& connector = world.connectors.front();
  double gravity[3] = {world.gravity.dot(plane.x), world.gravity.dot(plane.y), 0};
  model.gravity(gravity);
  for (std::size_t k = 0; k < chain.links; ++k) {
    double arm[3] = {0, connector.rest[chain.link(k)], 0};
    model.mass(static_cast<int>(k), connector.particle_mass[chain.particle(k + 1)]);
    model.to_joint(static_cast<int>(k), arm);
  }
}

void load_pins(const World& world, const Chain& chain, const Plane& plane,
               std::vector<double>& state) {
  const Connector& connector = world.connectors.front();
  state.assign(2 * chain.links, 0);
  double angle_before = 0, spin_before = 0;
  for (std::size_t k = 0; k < chain.links; ++k) {
    const std::size_t from = chain.particle(k), to = chain.particle(k + 1);
    const Vec3 along = connector.position[to] - connector.position[from];
    const Vec3 moves = connector.velocity[to] - connector.velocity[from];
    const double x = along.dot(plane.x), y = along.dot(plane.y);
    const double angle = std::atan2(x, -y);  // from down, towards x
    const double spin = (x * moves.dot(plane.y) - y * moves.dot(plane.x)) / (x * x + y * y);
    state[k] = angle - std::exchange(angle_before, angle);
    state[chain.links + k] = spin - std::exchange(spin_before, spin);
  }
}

void store_pins(const std::vector<double>& state, const Chain& chain, const Plane& plane,
                World& world) {
  Connector& connector = world.connectors.front();
  double angle = 0, spin = 0;
  for (std::size_t k = 0; k < chain.links; ++k) {
    angle += state[k];
    spin += state[chain.links + k];
    const std::size_t from = chain.particle(k), to = chain.particle(k + 1);
    const double rest = connector.rest[chain.link(k)], s = std::sin(angle), c = std::cos(angle);
    connector.position[to] = connector.position[from] + rest * (s * plane.x - c * plane.y);
    connector.velocity[to] = connector.velocity[from] + rest * spin * (c * plane.x + s * plane.y);
  }
}

}  // namespace taut::sdfast
