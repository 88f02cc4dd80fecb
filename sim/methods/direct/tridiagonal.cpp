#include "sim/methods/direct/tridiagonal.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

// Minors of a matrix with 2 on its diagonal grow by at most 2 a row and, where light particles sit
// between heavy ones, may fall by 10^-6 a row: this many rows stay far from overflow both ways.
constexpr std::size_t kRowsPerScaling = 32;

// A pivot this small beside its diagonal is rounding: the row says nothing.
constexpr double kNoPivot = 1e-13;

/// The leading minors from one end, one row at a time.
struct Minors {
  double before = 0, now = 1, sum = 0;  // q_{i-2}, q_{i-1}, z_{i-1}
  bool singular = false;

  [[gnu::always_inline]] void row(double d, double e, double r) {
    const double loss = e * e * before;
    sum = r * now + e * sum;
    before = now;
    now = d * now - loss;
    singular |= !(now > kNoPivot * d * before);
  }
  void rescale() {
    const double scale = 1 / now;
    before *= scale;
    sum *= scale;
    now = 1;
  }
};

/// Plain elimination that leaves out rows without a pivot.
void solve_singular(std::size_t n, const double* d, const double* e, const double* r, double* x,
                    double* pivot) {
  double carry = 0, sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double p = d[i] - carry;
    pivot[i] = p > kNoPivot * d[i] ? 1 / p : 0;
    sum = r[i] + (i > 0 ? e[i - 1] * pivot[i - 1] * sum : 0);
    x[i] = sum;
    if (i + 1 < n) carry = e[i] * e[i] * pivot[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    x[i] = pivot[i] * (x[i] + (i + 1 < n ? e[i] * x[i + 1] : 0));
  }
}

}  // namespace

TAUT_VECTOR_CLONES
void solve_tridiagonal(std::size_t n, const double* __restrict d, const double* __restrict e,
                       const double* __restrict r, double* __restrict x, double* __restrict work) {
  if (n == 0) return;  // a body that flies alone
  double* __restrict q = work;
  double* __restrict z = work + n;
  double* __restrict b = work + 2 * n;
  // Rows 0..m-1 go down, rows n-1..m+1 go up, and row m joins them.
  const std::size_t m = n / 2, pairs = (n - 1) / 2;
  Minors down, up;
  for (std::size_t k = 0; k < pairs;) {
    const std::size_t stop = std::min(pairs, k + kRowsPerScaling);
    for (; k < stop; ++k) {
      const std::size_t i = k, j = n - 1 - k;
      down.row(d[i], i > 0 ? e[i - 1] : 0, r[i]);
      up.row(d[j], k > 0 ? e[j] : 0, r[j]);
      q[i] = down.now, z[i] = down.sum, b[i] = e[i] * down.before;
      q[j] = up.now, z[j] = up.sum, b[j] = e[j - 1] * up.before;
    }
    down.rescale();
    up.rescale();
  }
  if (m > pairs) {
    down.row(d[pairs], pairs > 0 ? e[pairs - 1] : 0, r[pairs]);
    q[pairs] = down.now, z[pairs] = down.sum, b[pairs] = e[pairs] * down.before;
  }
  if (down.singular || up.singular) return solve_singular(n, d, e, r, x, work);

  q[m] = 1, z[m] = b[m] = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double inverse = 1 / q[i];
    z[i] *= inverse;
    b[i] *= inverse;
  }
  double pivot = d[m], sum = r[m];
  if (m > 0) pivot -= e[m - 1] * b[m - 1], sum += e[m - 1] * z[m - 1];
  if (m + 1 < n) pivot -= e[m] * b[m + 1], sum += e[m] * z[m + 1];
  if (!(pivot > kNoPivot * d[m])) return solve_singular(n, d, e, r, x, work);
  double above = sum / pivot, below = above;
  x[m] = above;
  for (std::size_t k = 1; k <= pairs; ++k) {
    above = x[m - k] = z[m - k] + b[m - k] * above;
    below = x[m + k] = z[m + k] + b[m + k] * below;
  }
  if (m > pairs) x[0] = z[0] + b[0] * above;
}

/// Of the matrix scaled to a diagonal of 1, whose leading minors are Q_i, the pivots are Q_i /
/// Q_{i-1}.
TAUT_VECTOR_CLONES
void factor_twisted(std::size_t n, double* __restrict pivot, double* __restrict up,
                    double* __restrict down, double* __restrict work) {
  if (n == 0) return;
  const std::size_t m = n / 2;
  double* __restrict couple = work;  // what row i and the next take from each other
  double* __restrict before = work + n;
  double* __restrict now = work + 2 * n;
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
    if (k % kRowsPerScaling == 0) d0 /= d1, u0 /= u1, d1 = u1 = 1;
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
