// Free bodies, moved by constraints one after another.
#pragma once

#include "sim/links/mechanism.h"

namespace taut::methods {

/// How easily the carried point `along` moves, a gradient of any length: 1/kg of it squared.
double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state);
/// The same of a whole body: `by_place` is the gradient by its place (world axes), `by_turn` that
/// by its turn (m, body axes).
double mobility(const Mechanism& mechanism, std::size_t body, const Vec3& by_place,
                const Vec3& by_turn);

/// Moves the body that carries a point as `by` (kg m) at that point does, and all its points.
void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state);
/// The same of a whole body: `by` moves its centre of mass, `turn` (kg m^2, body axes) turns it.
void pull(const Mechanism& mechanism, std::size_t body, const Vec3& by, const Vec3& turn,
          double* state);

}  // namespace taut::methods
