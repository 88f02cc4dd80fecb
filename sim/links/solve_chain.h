// The elimination of the tensions, of one connector or of many side by side, a lane each. No
// function of the standard library is used, nor one that is not always inlined: see sim/batch.
#pragma once

#include <cstddef>
#include <limits>

#include "sim/links/link_loops.h"

namespace taut {

/// Minors of a matrix with 2 on its diagonal grow by at most 2 a row and, where light particles sit
/// between heavy ones, may fall by 10^-6 a row: this many rows stay far from overflow both ways.
template <typename T>
inline constexpr std::size_t kRowsPerScaling = sizeof(Element<T>) == sizeof(double) ? 32 : 4;

/// A pivot this small beside its diagonal says nothing: of a chain that is straight between two
/// holds.
template <typename T>
inline constexpr auto kNoPivot = Element<T>(sizeof(Element<T>) == sizeof(double) ? 1e-13 : 5e-5);

/// The minors as an elimination meets them that goes down from the first row, or up from the last.
template <typename T>
struct ChainHalf {
  T before = {}, now = T{} + Element<T>(1),
    rest = T{} + Element<T>(1);  // q_{i-2}, q_{i-1}, g_{i-1}
  T sum = {};                    // z_{i-1}

  [[gnu::always_inline]] void row(const T& shared, const T& next, const T& sine_squared,
                                  const T& off_diagonal, const T& right) {
    sum = right * now + off_diagonal * sum;
    rest = shared * rest + sine_squared * before;
    before = now;
    now = next * now + rest;
  }
  [[gnu::always_inline]] void rescale() {
    const T scale = Element<T>(1) / now;
    before *= scale, rest *= scale, sum *= scale;
    now = T{} + Element<T>(1);
  }
};

/// See direct::solve_chain().
template <typename T>
[[gnu::always_inline]] inline void solve_chain_loop(
    std::size_t n, const T* __restrict diagonal_first, const T* __restrict diagonal_second,
    const T* __restrict off_diagonal, const T* __restrict sine_squared, const T* __restrict right,
    T* __restrict x, T* __restrict scratch) {
  if (n == 0) return;  // a body that flies alone
  T* __restrict q = scratch;
  T* __restrict z = scratch + n;
  T* __restrict b = scratch + 2 * n;
  // Rows 0..m-1 go down, rows n-1..m+1 go up, and row m joins them.
  const std::size_t m = n / 2, pairs = (n - 1) / 2;
  ChainHalf<T> above, below;
  const T none = {}, one = T{} + Element<T>(1);
  const auto down = [&](std::size_t i) {
    const bool first = i == 0;
    above.row(diagonal_first[i], diagonal_second[i], first ? none : sine_squared[i - 1],
              first ? none : off_diagonal[i - 1], right[i]);
    q[i] = above.now, z[i] = above.sum, b[i] = off_diagonal[i] * above.before;
  };
  const auto up = [&](std::size_t j) {
    const bool last = j + 1 == n;
    below.row(diagonal_second[j], diagonal_first[j], last ? none : sine_squared[j],
              last ? none : off_diagonal[j], right[j]);
    q[j] = below.now, z[j] = below.sum, b[j] = off_diagonal[j - 1] * below.before;
  };
  for (std::size_t k = 0; k < pairs;) {
    const std::size_t next = k + kRowsPerScaling<T>, stop = next < pairs ? next : pairs;
    for (; k < stop; ++k) {
      down(k);
      up(n - 1 - k);
    }
    above.rescale();
    below.rescale();
  }
  if (m > pairs) down(pairs);

  q[m] = one, z[m] = none, b[m] = none;
  for (std::size_t i = 0; i < n; ++i) {
    const T inverse = Element<T>(1) / q[i];
    z[i] *= inverse;
    b[i] *= inverse;
  }
  T sum = right[m];
  T pivot =
      diagonal_first[m] * above.rest / above.now + diagonal_second[m] * below.rest / below.now;
  if (m > 0) {
    sum += off_diagonal[m - 1] * z[m - 1];
    pivot += sine_squared[m - 1] * above.before / above.now;
  }
  if (m + 1 < n) {
    sum += off_diagonal[m] * z[m + 1];
    pivot += sine_squared[m] * below.before / below.now;
  }
  constexpr auto kInfinite = std::numeric_limits<Element<T>>::infinity();
  pivot = pivot > kNoPivot<T> * (diagonal_first[m] + diagonal_second[m]) ? pivot : T{} + kInfinite;
  T before = sum / pivot, after = before;
  x[m] = before;
  for (std::size_t k = 1; k <= pairs; ++k) {
    before = x[m - k] = z[m - k] + b[m - k] * before;
    after = x[m + k] = z[m + k] + b[m + k] * after;
  }
  if (m > pairs) x[0] = z[0] + b[0] * before;
}

}  // namespace taut
