// The coefficients of Radau IIA with three stages, of order 5.
#pragma once

#include <array>

#include "sim/motion/types.h"

namespace taut::direct {

/// Hairer and Wanner, Solving ODEs II, IV.5 and IV.8: with the inverse of the Runge-Kutta matrix
/// brought to a real eigenvalue and a complex pair, a Newton iteration takes one real and one
/// complex system of the size of the state.
struct RadauTableau {
  static const RadauTableau& get();

  Vec3 node;      // of a stage, as a share of the step; the last is 1
  Mat3 inverse;   // of the Runge-Kutta matrix
  double real;    // the real eigenvalue of `inverse`
  double re, im;  // one of the pair
  /// inverse = to_stage diag(real, pair) from_stage: stages are to_stage times the transformed
  /// ones, of which the second less i times the third belongs to re + i im.
  Mat3 to_stage, from_stage;
  /// Weights of the stages' differences from the start in an estimate of the error of order 3.
  Vec3 error;
};

}  // namespace taut::direct
