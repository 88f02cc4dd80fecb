#include "sim/methods/direct/tridiagonal.h"

#include <algorithm>
#include <limits>

#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

// Minors of a matrix with 2 on its diagonal grow by at most 2 a row and, where light particles sit
// between heavy ones, may fall by 10^-6 a row: this many rows stay far from overflow both ways.
constexpr std::size_t kRowsPerScaling = 32;

// A pivot this small beside its diagonal says nothing: of a chain that is straight between two
// holds.
constexpr double kNoPivot = 1e-13;

/// The rows as an elimination needs them that goes down from the first one, or up from the last:
/// what the minors from one end come to.
struct Chain {
  const double *near, *far, *turned;
  struct Half {
    double before = 0, now = 1, rest = 1;  // q_{i-2}, q_{i-1}, g_{i-1}
    void rescale(double scale) { before *= scale, rest *= scale, now = 1; }
  };

  [[gnu::always_inline]] static void row(Half& half, double shared, double next, double turn) {
    half.rest = shared * half.rest + turn * half.before;
    half.before = half.now;
    half.now = next * half.now + half.rest;
  }
  [[gnu::always_inline]] void down(Half& half, std::size_t i) const {
    row(half, near[i], far[i], i > 0 ? turned[i - 1] : 0);
  }
  [[gnu::always_inline]] void up(Half& half, std::size_t i, std::size_t n) const {
    row(half, far[i], near[i], i + 1 < n ? turned[i] : 0);
  }
  double pivot(std::size_t m, std::size_t n, const Half& above, const Half& below) const {
    double sum = near[m] * above.rest / above.now + far[m] * below.rest / below.now;
    if (m > 0) sum += turned[m - 1] * above.before / above.now;
    if (m + 1 < n) sum += turned[m] * below.before / below.now;
    return sum > kNoPivot * (near[m] + far[m]) ? sum : std::numeric_limits<double>::infinity();
  }
};

[[gnu::always_inline]] inline void solve_from_both_ends(const Chain& a, std::size_t n,
                                                        const double* __restrict e,
                                                        const double* __restrict r,
                                                        double* __restrict x,
                                                        double* __restrict work) {
  if (n == 0) return;  // a body that flies alone
  double* __restrict q = work;
  double* __restrict z = work + n;
  double* __restrict b = work + 2 * n;
  // Rows 0..m-1 go down, rows n-1..m+1 go up, and row m joins them.
  const std::size_t m = n / 2, pairs = (n - 1) / 2;
  Chain::Half above, below;
  double above_sum = 0, below_sum = 0;  // z_{i-1}
  const auto down = [&](std::size_t i) {
    above_sum = r[i] * above.now + (i > 0 ? e[i - 1] : 0) * above_sum;
    a.down(above, i);
    q[i] = above.now, z[i] = above_sum, b[i] = e[i] * above.before;
  };
  const auto up = [&](std::size_t j) {
    below_sum = r[j] * below.now + (j + 1 < n ? e[j] : 0) * below_sum;
    a.up(below, j, n);
    q[j] = below.now, z[j] = below_sum, b[j] = e[j - 1] * below.before;
  };
  for (std::size_t k = 0; k < pairs;) {
    const std::size_t stop = std::min(pairs, k + kRowsPerScaling);
    for (; k < stop; ++k) {
      down(k);
      up(n - 1 - k);
    }
    const double scale_above = 1 / above.now, scale_below = 1 / below.now;
    above.rescale(scale_above), above_sum *= scale_above;
    below.rescale(scale_below), below_sum *= scale_below;
  }
  if (m > pairs) down(pairs);

  q[m] = 1, z[m] = b[m] = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double inverse = 1 / q[i];
    z[i] *= inverse;
    b[i] *= inverse;
  }
  double sum = r[m];
  if (m > 0) sum += e[m - 1] * z[m - 1];
  if (m + 1 < n) sum += e[m] * z[m + 1];
  double before = sum / a.pivot(m, n, above, below), after = before;
  x[m] = before;
  for (std::size_t k = 1; k <= pairs; ++k) {
    before = x[m - k] = z[m - k] + b[m - k] * before;
    after = x[m + k] = z[m + k] + b[m + k] * after;
  }
  if (m > pairs) x[0] = z[0] + b[0] * before;
}

}  // namespace

TAUT_VECTOR_CLONES
void solve_chain(std::size_t n, const double* near, const double* far, const double* e,
                 const double* turned, const double* r, double* x, double* work) {
  solve_from_both_ends(Chain{near, far, turned}, n, e, r, x, work);
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
