#include "sim/study/refined.h"

#include <cmath>

#include "sim/motion/stop.h"

namespace taut::study {

double distance_between(const ReferenceSolution& reference, const World& world,
                        const Timeline& timeline, const MethodChoice& candidate,
                        const Distance& distance, double cpu_cap) {
  const WorkLimit limit({.cpu_time = cpu_cap});
  ComparedRun compared(reference, world, timeline, candidate, distance);
  try {
    for (std::size_t k = 0; k < reference.known; ++k) compared.next();
  } catch (const Diverged&) {
    return INFINITY;
  }
  return compared.error();
}

std::optional<double> error_of_chain(double twice, double four) {
  constexpr double kSlowest = 0.9;  // the factor above which nothing can be told
  if (twice == 0 && four == 0) return 0;
  const double factor = std::abs(four / twice - 1);
  if (!(factor < kSlowest)) return std::nullopt;
  return twice / (1 - factor);
}

}  // namespace taut::study
