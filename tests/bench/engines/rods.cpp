#include "tests/bench/engines/rods.h"

#include <stdexcept>

namespace taut::engines {
namespace {

const Hold& top(const World& world) {
  return world.connectors[0].holds.front();
}

void check(const World& world) {
  const auto need = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  need(world.connectors.size() == 1, "engines are given one connector");
  const Connector& connector = world.connectors[0];
  const std::size_t last = connector.particles() - 1;
  need(!connector.holds.empty() && connector.holds[0].particle == 0 &&
           is_prescribed(world, connector.holds[0].to),
       "engines are given a connector that hangs from a fixed or driven point");
  need(connector.holds.size() == 1 ||
           (connector.holds.size() == 2 && connector.holds[1].particle == last &&
            !is_prescribed(world, connector.holds[1].to)),
       "engines are given a connector that nothing but a free body holds below");
  need(world.bodies.size() + 1 == connector.holds.size(), "engines are given one body at most");
}

}  // namespace

Rods::Rods(const World& world) {
  check(world);
  const Connector& connector = world.connectors[0];
  const std::size_t links = connector.links();
  for (std::size_t i = 0; i < links; ++i) {
    // Every particle is shared by its two links; the last belongs to the last link alone.
    const double upper = connector.particle_mass[i] / 2;
    const double lower = connector.particle_mass[i + 1] / (i + 1 < links ? 2 : 1);
    Rod rod;
    rod.along = connector.position[i + 1] - connector.position[i];
    rod.mass = upper + lower;
    rod.centre = lower / rod.mass;
    rod.inertia = upper * lower / rod.mass * rod.along.squaredNorm();
    rod.spin = rod.along.cross(connector.velocity[i + 1] - connector.velocity[i]) /
               rod.along.squaredNorm();
    rods_.push_back(rod);
  }
  if (connector.holds.size() == 1) return;
  const Attachment& to = connector.holds[1].to;
  const Body& body = world.bodies[to.body];
  const Mat3 turn = body.rotation.toRotationMatrix();
  body_ = to.body;
  at_start_ = body.rotation;
  load_ = Load{body.bare.mass, turn * (body.bare.centre - to.point),
               turn * body.bare.inertia * turn.transpose(), body.spin};
}

Vec3 Rods::gravity(const World& world, double time) const {
  return world.gravity - hold_motion(world, top(world).to, time).acceleration;
}

void Rods::place(const std::vector<Vec3>& ends, const Quat& turn, double time, World& world) const {
  Connector& connector = world.connectors[0];
  const Vec3 from = hold_motion(world, top(world).to, time).position;
  for (std::size_t i = 0; i < ends.size(); ++i) connector.position[i + 1] = from + ends[i];
  if (load_) {
    const Vec3 point = connector.holds[1].to.point;
    Body& body = world.bodies[body_];
    body.rotation = turn * at_start_;
    body.position =
        connector.position.back() + body.rotation * (body.mass_properties.centre - point);
  }
  place_held(world, time);
}

}  // namespace taut::engines
