// What an impact throws back, so that it makes no energy.
#pragma once

#include <cmath>

namespace taut::contact {

/// Kinetic energies (J) of what an impact moves: before it; after it as Newton's law has it, and
/// without restitution; and half of the product of both velocities after it with the masses.
struct ImpactEnergies {
  double before = 0, thrown = 0, stopped = 0, mixed = 0;
};

/// Of a rebound by Newton's law less than this share of the energy before is gained by rounding.
inline constexpr double kGainedByRounding = 1e-10;

inline bool gains_energy(double before, double thrown) {
  return thrown > (1 + kGainedByRounding) * before;
}

/// The largest share with which `thrown` velocities, and with the rest `stopped` ones, have no more
/// energy than before. Without restitution none is gained, so there is one.
inline double share_thrown_back(const ImpactEnergies& energy) {
  const double square = energy.stopped - 2 * energy.mixed + energy.thrown;
  const double half = energy.mixed - energy.stopped, spare = energy.before - energy.stopped;
  if (!(spare > 0) || !(square > 0)) return 0;
  // The larger root, without cancellation.
  const double root = std::sqrt(half * half + square * spare);
  return half > 0 ? spare / (half + root) : (root - half) / square;
}

}  // namespace taut::contact
