#include "tests/bench/engines/rods.h"

#include <stdexcept>

namespace taut::engines {
namespace {

/// The hold of the upper end, or null.
const Hold* top(const World& world) {
  const std::vector<Hold>& holds = world.connectors[0].holds;
  return holds.empty() || holds[0].particle > 0 ? nullptr : &holds[0];
}

void check(const World& world) {
  const auto need = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  need(world.connectors.size() == 1, "engines are given one connector");
  const Connector& connector = world.connectors[0];
  const std::size_t last = connector.particles() - 1;
  const std::size_t below = top(world) ? 1 : 0;
  need(!top(world) || is_prescribed(world, top(world)->to),
       "engines are given a connector that hangs from a fixed or driven point, or from none");
  need(connector.holds.size() == below ||
           (connector.holds.size() == below + 1 && connector.holds[below].particle == last &&
            !is_prescribed(world, connector.holds[below].to)),
       "engines are given a connector that nothing but a free body holds below");
  need(world.bodies.size() + below == connector.holds.size(), "engines are given one body at most");
  if (world.obstacles.empty()) return;
  need(!connector.pulls, "engines are given rods beside obstacles");
  need(!top(world) || top(world)->to.kind == Attachment::Kind::fixed,
       "engines are given no driven end beside obstacles");
  for (const Obstacle& obstacle : world.obstacles) {
    need(!obstacle.path, "engines are given obstacles that stand still");
    need(obstacle.shape.rounding == 0, "engines are given no rounded edges");
    need(obstacle.static_friction == obstacle.kinetic_friction,
         "engines are given one coefficient of friction");
  }
}

}  // namespace

Rods::Rods(const World& world) {
  check(world);
  const Connector& connector = world.connectors[0];
  const std::size_t links = connector.links();
  for (std::size_t i = 0; i < links; ++i) {
    // Every particle is shared by its two links; one at an end belongs to its link alone.
    const double upper = connector.particle_mass[i] / (i == 0 && !top(world) ? 1 : 2);
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
  hangs_ = top(world) != nullptr;
  if (!hangs_) velocity_ = connector.velocity[0];
  start_ = connector.position[0];
  radius_ = connector.radius;
  obstacles_ = world.obstacles;
  std::erase_if(obstacles_, [&](const Obstacle& o) { return !o.touches(connector.category); });
  for (Obstacle& obstacle : obstacles_) obstacle.place.position -= start_;
  if (world.bodies.empty()) return;
  const Attachment& to = connector.holds.back().to;
  const Body& body = world.bodies[to.body];
  const Mat3 turn = body.rotation.toRotationMatrix();
  body_ = to.body;
  at_start_ = body.rotation;
  load_ = Load{body.bare.mass, turn * (body.bare.centre - to.point),
               turn * body.bare.inertia * turn.transpose(), body.spin};
}

std::vector<Bead> Rods::beads() const {
  std::vector<Bead> beads;
  if (obstacles_.empty()) return beads;
  if (!hangs_) beads.push_back({0, -rods_[0].centre * rods_[0].along});
  for (std::size_t i = 0; i < rods_.size(); ++i) {
    if (i + 1 == rods_.size() && load_) break;  // the body holds it
    beads.push_back({i, (1 - rods_[i].centre) * rods_[i].along});
  }
  return beads;
}

Vec3 Rods::gravity(const World& world, double time) const {
  if (!hangs_) return world.gravity;
  return world.gravity - hold_motion(world, top(world)->to, time).acceleration;
}

void Rods::place(const std::vector<Vec3>& ends, const Quat& turn, double time, World& world) const {
  Connector& connector = world.connectors[0];
  const Vec3 from = hangs_ ? hold_motion(world, top(world)->to, time).position : start_;
  for (std::size_t i = 0; i < ends.size(); ++i) connector.position[i] = from + ends[i];
  if (load_) {
    const Vec3 point = connector.holds.back().to.point;
    Body& body = world.bodies[body_];
    body.rotation = turn * at_start_;
    body.position =
        connector.position.back() + body.rotation * (body.mass_properties.centre - point);
  }
  place_held(world, time);
}

}  // namespace taut::engines
