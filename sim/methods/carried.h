// Points that free bodies carry, moved by constraints one after another.
#pragma once

#include "sim/links/mechanism.h"

namespace taut::methods {

/// How easily the carried point `along` moves, a gradient of any length: 1/kg of it squared.
double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state);

/// Moves the body that carries a point as `by` (kg m) at that point does, and all its points.
void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state);

}  // namespace taut::methods
