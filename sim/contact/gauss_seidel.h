// Impulses of bodies that touch, found one after another.
#pragma once

#include <span>

#include "sim/contact/body_touch.h"

namespace taut::contact {

/// The masses (kg) that a touch meets, of all bodies that it is between: impulses over the changes
/// of velocity that they make there.
struct EffectiveMass {
  double along = 0;            // the normal
  Mat3 across = Mat3::Zero();  // the normal: of the impulse that makes a change across it
  double least_across = 0;     // what is so light in no way
};
EffectiveMass effective_mass(std::span<const Mat6> mobility, const BodyTouch& at);

/// Projected Gauss-Seidel, as in Jean, The non-smooth contact dynamics method, 1999, and in games:
/// each touch in turn takes the push that makes its velocity Touch::least, or none, and friction
/// that stops it or is against its sliding. What static friction does not stop slides with the
/// kinetic one. Starts at BodyTouch::given, which `twists` (of all bodies) contain; `masses`
/// of each touch. Velocities and impulses (m/s, N s) may be displacements and what makes them
/// (m, kg m).
///
/// A body that lies on two points keeps the fourth part of the error in each sweep; sweeps end
/// where they change little, and after a fixed number, which is less than a high pile needs.
void relax(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists);

}  // namespace taut::contact
