// Symmetric tridiagonal systems.
#pragma once

#include <cstddef>

namespace taut::direct {

/// A symmetric positive definite tridiagonal matrix of n rows as L D L'. Zeros off the diagonal
/// make blocks: many chains are one matrix.
struct Tridiagonal {
  /// Factors the matrix with `diagonal` (n) and `off` (n-1, between rows i and i+1) in place:
  /// `diagonal` becomes 1/D, `off` the unit lower factor. Returns false where a pivot is not
  /// positive; that pivot is then taken as infinite, which leaves its unknown zero.
  static bool factor(std::size_t n, double* diagonal, double* off) {
    bool definite = true;
    double carry = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double pivot = diagonal[i] - carry;
      // A pivot that rounding alone could have left is no pivot.
      const bool good = pivot > 1e-14 * diagonal[i];
      definite &= good;
      diagonal[i] = good ? 1 / pivot : 0;
      if (i + 1 == n) break;
      carry = off[i];
      off[i] *= diagonal[i];
      carry *= off[i];
    }
    return definite;
  }

  /// Solves for one right side in place, with what factor() left.
  static void solve(std::size_t n, const double* inverse_pivot, const double* lower, double* x) {
    for (std::size_t i = 1; i < n; ++i) x[i] -= lower[i - 1] * x[i - 1];
    for (std::size_t i = 0; i < n; ++i) x[i] *= inverse_pivot[i];
    for (std::size_t i = n - 1; i-- > 0;) x[i] -= lower[i] * x[i + 1];
  }
};

}  // namespace taut::direct
