// Measures of a world: energy, momentum and stretch; and how curves wind about each other and about
// themselves.
#pragma once

#include <span>
#include <vector>

#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut {

/// Kinetic energy of free bodies and of particles that no body holds, J.
double kinetic_energy(const World& world);
/// Potential energy in the world's gravity, zero at the origin, J; of held particles only of those
/// whose mass changes, as rope is paid out.
double potential_energy(const World& world);
/// The energy stored in links that stretch or bend, J.
double elastic_energy(const World& world);
/// The sum of all three, J.
double energy(const World& world);
/// Linear momentum of everything that moves freely, kg m/s.
Vec3 linear_momentum(const World& world);
/// Angular momentum about `about` of everything that moves freely, kg m^2/s.
Vec3 angular_momentum(const World& world, const Vec3& about = Vec3::Zero());
/// The largest |link length / rest length - 1| of any link (rest length zero: the gap in m); of
/// strings, which may be shorter, without the bars.
double stretch_max(const World& world);

/// The mass of everything that moves freely, kg.
double moving_mass(const World& world);
/// The length of the longest connector; where that is 0 or less than a thousandth of it, the
/// largest RMS distance of a free body's mass from what holds it, or from its centre of mass, m.
double length_scale(const World& world);
/// An energy to compare changes with: that of lifting everything that moves freely by the length
/// scale, and its present motion, J.
double energy_scale(const World& world);
/// True where no path moves a body or a hold, no link is damped and no air resists, so that what
/// moves freely keeps its energy: energy_scale() then tells how much a change of it is.
bool is_closed(const World& world);

// How curves wind about each other and about themselves.

/// A polygon: its corners (m); closed from the last to the first, or open.
struct Curve {
  std::vector<Vec3> corners;
  bool closed = false;
};

/// The curve of a connector's particles: closed where a joint ties its ends together.
Curve curve_of(const World& world, std::size_t connector);

/// Gauss's linking number of two curves that do not cross: how often one winds about the other. An
/// open curve is closed far away: straight outwards from both ends, and round there. Then it is a
/// whole number, which only a crossing changes.
/// Each pair of segments counts with the solid angle of directions from which they are seen to
/// cross (Klenin and Langowski, Computation of writhe in modeling of supercoiled DNA, Biopolymers
/// 54, 2000).
int linking_number(const Curve& one, const Curve& other);

/// The writhe of a curve: how many more crossings are right-handed than left-handed, as the mean of
/// all views. Of an open curve the part of its own segments.
double writhe(const Curve& curve);

}  // namespace taut
