#include "sim/simulation.h"

#include <stdexcept>

namespace taut {

Simulation::Simulation(World world, std::unique_ptr<Method> method)
    : world_(std::move(world)), method_(std::move(method)) {}

void Simulation::advance_to(double time) {
  if (!(time >= world_.time)) throw std::invalid_argument("a simulation cannot go back in time");
  if (time > world_.time) method_->advance(world_, time);
}

}  // namespace taut
