// Symmetric tridiagonal systems, solved from both ends at once.
#pragma once

#include <cstddef>

namespace taut::direct {

/// Solves A x = r for a chain of n links whose first or last point is free: the diagonal of A is
/// `diagonal_first` + `diagonal_second`, from the particles that a link shares with the row before
/// and with the next; beside it stands -`off_diagonal` (n-1), with entries sqrt(b_i a_{i+1}) times
/// the cosine of a turn, a and b the two parts of the diagonal; `sine_squared` (n-1) is the square
/// of the same times its sine. `scratch` takes 3n doubles.
///
/// Elimination without divisions: with the leading minors q_i = d_i q_{i-1} - e_i^2 q_{i-2} and
/// z_i = r_i q_{i-1} + e_i z_{i-1}, the rows read x_i = (z_i + e_{i+1} q_{i-1} x_{i+1}) / q_i, and
/// all divisions are done together. The same from the last row backwards; the halves meet in the
/// middle, which halves the chain of operations that wait for each other.
///
/// With q_i = b_i q_{i-1} + g_i the minors are sums, g_i = a_i g_{i-1} + sine_squared_{i-1}
/// q_{i-2}, and every digit of nearly singular systems counts, such as those of straight chains
/// between a hold and a load a million times as heavy as they. Where a system leaves the tensions
/// open, the middle one is zero.
void solve_chain(std::size_t n, const double* diagonal_first, const double* diagonal_second,
                 const double* off_diagonal, const double* sine_squared, const double* right,
                 double* x, double* scratch);

/// A tridiagonal matrix whose columns are diagonally dominant, factored from both ends: `pivot`
/// (n) holds its diagonal and becomes inverse pivots; `up` (entry above the diagonal in row i, at
/// i) and `down` (entry below it in column i, at i) hold -its off-diagonals and become multipliers.
/// `scratch` takes 3n doubles. No division waits for another, as above.
void factor_twisted(std::size_t n, double* pivot, double* up, double* down, double* scratch);

/// Solves for `columns` right sides in place, `stride` apart, with what factor_twisted() left.
void solve_twisted(std::size_t n, const double* pivot, const double* up, const double* down,
                   int columns, std::size_t stride, double* x);

}  // namespace taut::direct
