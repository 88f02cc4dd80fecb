// Worlds of links that touch thin wires and thick posts between their beads.
#pragma once

#include "contact_worlds.h"
#include "tests/support/dice.h"

namespace taut::link_worlds {

using namespace contact_worlds;
using worlds::kGravity;

inline constexpr double kWire = 5e-4;       // m, radius of a wire
inline constexpr double kThickness = 1e-3;  // m, radius of a link
inline constexpr double kThin = 1e-5;       // m, the same of a rod that rocks

/// A rod of a metre, two beads and the link between them, over a wire along z through the origin,
/// which it touches at `share` of its way.
inline World rod(double share, double angle, double above, const Obstacle& wire) {
  World world;
  const Vec3 along(std::cos(angle), std::sin(angle), 0), normal(-along.y(), along.x(), 0);
  Connector link = straight_connector("rod", 1, 0.2, 2,
                                      (kWire + kThickness + above) * normal - share * along, along);
  link.radius = kThickness;
  link.links_touch = true;
  world.connectors = {link};
  world.obstacles = {wire};
  finish(world);
  return world;
}

/// A rod of a metre and two beads over a table of the half width `half` (m), tipped about an edge.
inline World rocking_rod(double half, double angle, double restitution) {
  const Vec3 along(std::cos(angle), -std::sin(angle), 0), normal(-along.y(), along.x(), 0);
  const Vec3 centre = Vec3(half, 0, 0) + kThin * normal - half * along;
  World world;
  Connector rod = straight_connector("rod", 1, 0.2, 2, centre - along / 2, along);
  rod.radius = kThin;
  rod.links_touch = true;
  world.connectors = {rod};
  Obstacle table = obstacle(box_shape(Vec3(2 * half, 0.2, 1)), 1, restitution);
  table.place.position = Vec3(0, -0.1, 0);
  world.obstacles = {table};
  finish(world);
  return world;
}

/// A rope that falls on thick posts of any kind, with up to so much friction and restitution.
inline World rope_on_posts(unsigned seed, double friction = 1, double restitution = 1) {
  Dice dice(seed);
  World world;
  const auto particles = static_cast<std::size_t>(2 + dice.pick(11));
  Connector rope = straight_connector("rope", 1, dice.scale(0.02, 1), particles,
                                      Vec3(dice.between(-0.8, -0.2), 0.8, 0),
                                      (Vec3::UnitX() + dice.within(0.2)).normalized());
  rope.radius = dice.pick(2) == 0 ? dice.scale(1e-4, 0.01) : 0;
  rope.links_touch = true;
  const Vec3 velocity = dice.within(3);
  for (Vec3& moves : rope.velocity) moves = velocity;
  world.connectors = {rope};
  for (int k = 0; k < 5; ++k) {
    const double radius = dice.scale(0.02, 0.15);
    const Shape shape = dice.pick(2) == 0 ? capsule_shape(radius, 1.5)
                                          : box_shape(Vec3(radius, 1, radius), 0.1 * radius);
    const double rubs = dice.between(0, 1), bounces = dice.between(0, 1);
    Obstacle post = obstacle(shape, friction * rubs, restitution * bounces);
    post.place = {Vec3(-0.6 + 0.3 * k, dice.between(0, 0.4), 0),
                  rotation_between(Vec3::UnitY(), (Vec3::UnitZ() + dice.within(0.6)).normalized())};
    world.obstacles.push_back(post);
  }
  finish(world);
  return world;
}

}  // namespace taut::link_worlds
