// Friction that is approached from a viscous one.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut::contact {

/// The creep of what sticks, see respond().
inline constexpr double kCreep = 1e-14;

/// A homotopy: solves with viscous friction first, then with less and less creep, as fast as
/// solutions lead to each other. `solve` takes a creep, begins at what it found last, and says
/// whether it found a solution; `keep` and `restore` remember that and return to it. Returns the
/// least creep with a solution, which `solve` found last; infinite where there is none.
template <typename Solve, typename Keep, typename Restore>
double approach_friction(const Solve& solve, const Keep& keep, const Restore& restore) {
  constexpr double kViscous = 1e4;             // friction that hardly matters
  constexpr double kLeap = 100, kLeast = 1.5;  // from one creep to the next
  double creep = kViscous, factor = kLeap;
  if (!solve(creep)) return std::numeric_limits<double>::infinity();
  while (creep > kCreep) {
    const double next = std::max(creep / factor, kCreep);
    keep();
    if (solve(next)) {
      creep = next;
      factor = std::min(factor * factor, kLeap);
      continue;
    }
    restore();
    factor = std::sqrt(factor);
    if (factor < kLeast) {
      solve(creep);
      break;
    }
  }
  return creep;
}

}  // namespace taut::contact
