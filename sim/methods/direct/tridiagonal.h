// Symmetric tridiagonal systems, solved from both ends at once.
#pragma once

#include <cstddef>

namespace taut::direct {

/// Solves A x = r for n rows, A with `diagonal` (n, near 2) and -`off` (n-1) beside it, positive
/// definite. `work` takes 3n doubles. Unknowns that the system leaves open come out as zero.
///
/// Elimination without divisions: with the leading minors q_i = d_i q_{i-1} - e_i^2 q_{i-2} and
/// z_i = r_i q_{i-1} + e_i z_{i-1}, the rows read x_i = (z_i + e_{i+1} q_{i-1} x_{i+1}) / q_i, and
/// all divisions are done together. The same from the last row backwards; the halves meet in the
/// middle, which halves the chain of operations that wait for each other.
void solve_tridiagonal(std::size_t n, const double* diagonal, const double* off,
                       const double* right, double* x, double* work);

/// A tridiagonal matrix whose columns are diagonally dominant, factored from both ends: `pivot`
/// (n) holds its diagonal and becomes inverse pivots; `up` (entry above the diagonal in row i, at
/// i) and `down` (entry below it in column i, at i) hold -its off-diagonals and become multipliers.
/// `work` takes 3n doubles. No division waits for another, as above.
void factor_twisted(std::size_t n, double* pivot, double* up, double* down, double* work);

/// Solves for `columns` right sides in place, `stride` apart, with what factor_twisted() left.
void solve_twisted(std::size_t n, const double* pivot, const double* up, const double* down,
                   int columns, std::size_t stride, double* x);

}  // namespace taut::direct
