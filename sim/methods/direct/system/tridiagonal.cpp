#include "sim/methods/direct/system/tridiagonal.h"

#include "sim/links/link_loops.h"
#include "sim/methods/direct/system/vector.h"

namespace taut::direct {
namespace {

// Divisions that keep the minors of factor_twisted() in range are done so often.
constexpr std::size_t kRows = kRowsPerScaling<double>;

}  // namespace

TAUT_VECTOR_CLONES
void solve_chain(std::size_t n, const double* diagonal_first, const double* diagonal_second,
                 const double* e, const double* sine_squared, const double* r, double* x,
                 double* scratch) {
  solve_chain_loop(n, diagonal_first, diagonal_second, e, sine_squared, r, x, scratch);
}

/// Of the matrix scaled to a diagonal of 1, whose leading minors are Q_i, the pivots are Q_i /
/// Q_{i-1}.
TAUT_VECTOR_CLONES
void factor_twisted(std::size_t n, double* __restrict pivot, double* __restrict up,
                    double* __restrict down, double* __restrict scratch) {
  if (n == 0) return;
  const std::size_t m = n / 2;
  double* __restrict couple = scratch;  // what row i and the next take from each other
  double* __restrict before = scratch + n;
  double* __restrict now = scratch + 2 * n;
  for (std::size_t i = 0; i < n; ++i) pivot[i] = 1 / pivot[i];
  for (std::size_t i = 0; i + 1 < n; ++i) couple[i] = up[i] * down[i] * (pivot[i] * pivot[i + 1]);
  before[m] = 1;
  before[0] = before[n - 1] = now[0] = now[n - 1] = 1;
  double d0 = 1, d1 = 1, u0 = 1, u1 = 1;  // the last two minors, going down and going up
  for (std::size_t k = 1; k < m; ++k) {
    const std::size_t i = k, j = n - 1 - k;
    const double d2 = d1 - couple[i - 1] * d0, u2 = u1 - couple[j] * u0;
    before[i] = d0 = d1, now[i] = d1 = d2;
    if (j > m) before[j] = u0 = u1, now[j] = u1 = u2;
    if (k % kRows == 0) d0 /= d1, u0 /= u1, d1 = u1 = 1;
  }
  now[m] = 1;
  if (m > 0) now[m] -= couple[m - 1] * before[m - 1] / now[m - 1];
  if (m + 1 < n) now[m] -= couple[m] * before[m + 1] / now[m + 1];
  for (std::size_t i = 0; i < n; ++i) pivot[i] *= before[i] / now[i];
  for (std::size_t i = 0; i + 1 < n; ++i) {
    down[i] *= i < m ? pivot[i] : pivot[i + 1];
    up[i] *= i < m ? pivot[i] : pivot[i + 1];
  }
}

namespace {

template <int kColumns>
[[gnu::always_inline]] inline void solve_columns(std::size_t n, const double* __restrict pivot,
                                                 const double* __restrict up,
                                                 const double* __restrict down, std::size_t stride,
                                                 double* __restrict x) {
  const std::size_t m = n / 2;
  double above[kColumns], below[kColumns];
  for (int c = 0; c < kColumns; ++c) above[c] = x[c * stride], below[c] = x[c * stride + n - 1];
  for (std::size_t k = 0; k < m; ++k) {
    const std::size_t i = k, j = n - 1 - k;
    for (int c = 0; c < kColumns; ++c) {
      double* __restrict r = x + c * stride;
      above[c] = r[i + 1] += down[i] * above[c];
      if (j > m) below[c] = r[j - 1] += up[j - 1] * below[c];
    }
  }
  for (int c = 0; c < kColumns; ++c) {
    double* __restrict r = x + c * stride;
    r[m] *= pivot[m];
    above[c] = below[c] = r[m];
  }
  for (std::size_t k = 1; k <= m; ++k) {
    for (int c = 0; c < kColumns; ++c) {
      double* __restrict r = x + c * stride;
      above[c] = r[m - k] = pivot[m - k] * r[m - k] + up[m - k] * above[c];
      if (m + k < n) below[c] = r[m + k] = pivot[m + k] * r[m + k] + down[m + k - 1] * below[c];
    }
  }
}

}  // namespace

TAUT_VECTOR_CLONES
void solve_twisted(std::size_t n, const double* pivot, const double* up, const double* down,
                   int columns, std::size_t stride, double* x) {
  if (n == 0) return;
  if (columns == 1) {
    solve_columns<1>(n, pivot, up, down, stride, x);
  } else if (columns == 2) {
    solve_columns<2>(n, pivot, up, down, stride, x);
  } else {
    solve_columns<3>(n, pivot, up, down, stride, x);
  }
}

}  // namespace taut::direct
