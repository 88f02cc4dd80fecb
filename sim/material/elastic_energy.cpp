#include <vector>

#include "sim/material/elements.h"
#include "sim/material/forces.h"
#include "sim/measure/measure.h"

double taut::elastic_energy(const World& world) {
  material::MaterialForces forces;
  forces.rebuild(world, 0);
  forces.place(world, world.time);
  std::vector<Vec3> position;
  for (const Connector& connector : world.connectors) {
    position.insert(position.end(), connector.position.begin(), connector.position.end());
  }
  double energy = 0;
  for (const material::StretchElement& link : forces.stretches()) {
    const double longer = (position[link.b] - position[link.a]).norm() - link.rest;
    energy += link.stiffness * longer * longer / 2;
  }
  Vec3 e0, e1;
  for (const material::BendElement& bend : forces.bends()) {
    forces.edges(bend, position.data()->data(), e0, e1);
    energy += material::Bend(e0, e1, bend.rest).energy(bend.stiffness);
  }
  for (const material::TwistElement& rod : forces.twists()) {
    const double twist = forces.twist(rod, position.data()->data());
    energy += rod.stiffness * twist * twist / 2;
  }
  return energy;
}
