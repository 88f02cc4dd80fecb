// How curves wind about each other and about themselves.
#pragma once

#include <span>
#include <vector>

#include "sim/world/world.h"

namespace taut {

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
