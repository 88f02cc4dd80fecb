#include "sim/run/coarser.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace taut {

void take_masses(World& world, const World& exact) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& coarse = world.connectors[c];
    const Connector& fine = exact.connectors[c];
    if (coarse.mass == 0 && fine.mass > 0) continue;  // modelled without
    std::ranges::fill(coarse.particle_mass, 0.0);
    double along = 0, link_start = 0;  // m, of the fine particle; of the coarse link
    std::size_t link = 0;
    for (std::size_t i = 0; i < fine.particles(); ++i) {
      if (i > 0) along += fine.rest[i - 1];
      while (link + 1 < coarse.links() && link_start + coarse.rest[link] < along) {
        link_start += coarse.rest[link++];
      }
      const double length = coarse.rest[link];
      const double ahead = length > 0 ? std::clamp((along - link_start) / length, 0.0, 1.0)
                                      : static_cast<double>(i) / static_cast<double>(fine.links());
      coarse.particle_mass[link] += (1 - ahead) * fine.particle_mass[i];
      coarse.particle_mass[link + 1] += ahead * fine.particle_mass[i];
    }
    if (!coarse.winch) continue;
    Winch winch = *coarse.winch;
    winch.particle_mass = coarse.particle_mass;
    winch.density = fine.winch->density;
    coarse.winch = std::make_shared<const Winch>(std::move(winch));
  }
  reweigh(world);
}

}  // namespace taut
