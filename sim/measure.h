// Energy, momentum and stretch of a world.
#pragma once

#include "sim/world.h"

namespace taut {

/// Kinetic energy of free bodies and of particles that no body holds, J.
double kinetic_energy(const World& world);
/// Potential energy in the world's gravity, zero at the origin, J.
double potential_energy(const World& world);
/// Linear momentum of everything that moves freely, kg m/s.
Vec3 linear_momentum(const World& world);
/// Angular momentum about `about` of everything that moves freely, kg m^2/s.
Vec3 angular_momentum(const World& world, const Vec3& about = Vec3::Zero());
/// The largest |link length / rest length - 1| of any link (rest length zero: the gap in m).
double stretch_max(const World& world);

}  // namespace taut
