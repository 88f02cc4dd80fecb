#include "sim/links/winch_tension.h"

#include <stdexcept>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"

namespace taut {

double winch_tension(const World& world, std::size_t index, std::size_t end) {
  const Connector& connector = world.connectors[index];
  if (!connector.winch || !connector.winch->paths[end]) {
    throw std::invalid_argument("the connector " + connector.name + " has no winch there");
  }
  Mechanism mechanism(world);
  TensionSystem system(mechanism);
  std::vector<double> state, right, tension;
  mechanism.load(world, state);
  mechanism.update(world.time, state.data());
  mechanism.right_side(right);
  system.assemble(mechanism);
  system.solve(right, tension);
  std::vector<double> slope(state.size());
  mechanism.differentiate(state.data(), tension.data(), slope.data());
  std::vector<Vec3> acceleration;
  for (std::size_t i = 0; i < mechanism.points(); ++i) {
    acceleration.emplace_back(Eigen::Map<const Vec3>(&slope[mechanism.velocity(i)]));
  }
  std::size_t first = 0;
  for (const Connector& other : world.connectors) {
    for (const Hold& hold : other.holds) {  // whose slopes are zero
      acceleration[first + hold.particle] = hold_motion(world, hold.to, world.time).acceleration;
    }
    first += other.particles();
  }
  return mechanism.drum_force(index, end, state.data(), tension.data(), acceleration);
}

}  // namespace taut
