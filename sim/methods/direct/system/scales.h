// Numbers that every kind of motion shares.
#pragma once

#include <cmath>

namespace taut::direct {

/// A particle without mass, which the model has no equation for, is taken to weigh this share of
/// everything that moves with it.
inline constexpr double kLeastMassShare = 1e-9;

/// An error of velocity counts for this time (s): a share of that in which a pendulum of `length`
/// (m) would turn it into an error of position.
inline double velocity_time_of(double length) {
  constexpr double kShare = 0.15;
  constexpr double kStandardGravity = 9.80665;  // m/s^2
  return kShare * std::sqrt(length / kStandardGravity);
}

}  // namespace taut::direct
