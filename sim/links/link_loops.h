// The loops over links, and the elimination of their tensions: of one connector, or of many side by
// side, a lane each. No function of the standard library is used, nor one that is not always
// inlined: see sim/batch.
#pragma once

#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>

namespace taut {

/// The number in each lane of a vector; a number itself.
template <typename T>
struct ElementOf {
  using Type = T;
};
template <typename T>
requires requires(T x) {
  x[0];
}
struct ElementOf<T> {
  using Type = std::remove_cvref_t<decltype(std::declval<T&>()[0])>;
};
template <typename T>
using Element = typename ElementOf<T>::Type;

/// Of a number, or of each lane.
template <typename T>
[[gnu::always_inline]] inline T square_root(T x) {
  if constexpr (std::is_floating_point_v<T>) {
    return std::is_same_v<T, float> ? static_cast<T>(__builtin_sqrtf(static_cast<float>(x)))
                                    : static_cast<T>(__builtin_sqrt(x));
  } else {
    for (std::size_t k = 0; k < sizeof(T) / sizeof(Element<T>); ++k) x[k] = square_root(x[k]);
    return x;
  }
}

// An array of directions has kComponents numbers a link: n of the first component, then n of the
// next. T is a number, or a vector with a connector's number in each lane (sim/batch).

/// The rows of the tensions' system, see direct::solve_chain(), which keep u . u'' = -|u'|^2.
template <int kComponents, typename T>
[[gnu::always_inline]] inline void assemble_loop(std::size_t n, const T* __restrict q,
                                                 const T* __restrict rate,
                                                 const T* __restrict coupling,
                                                 const T* __restrict weight,
                                                 T* __restrict off_diagonal,
                                                 T* __restrict sine_squared, T* __restrict right) {
  using Number = Element<T>;
  for (std::size_t i = 0; i < n; ++i) {
    T chord = {}, square = {};
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      const T turn = q[at + 1] - q[at];
      chord += turn * turn;
      square += rate[at] * rate[at];
    }
    // A chord of length d spans an angle of cosine 1 - d^2 / 2.
    off_diagonal[i] = coupling[i] * (Number(1) - Number(0.5) * chord);
    sine_squared[i] = coupling[i] * coupling[i] * (chord * (Number(1) - Number(0.25) * chord));
    right[i] = weight[i] * square;
  }
}

/// u'' as far as the unknowns x of that system cause it.
template <int kComponents, typename T>
[[gnu::always_inline]] inline void pull_loop(std::size_t n, const T* __restrict q,
                                             const T* __restrict next_gain,
                                             const T* __restrict last_gain,
                                             const T* __restrict own_gain, const T* __restrict x,
                                             T* __restrict out) {
  const T *q_before = q - 1, *x_before = x - 1;
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const T next = next_gain[i] * x[i + 1], last = last_gain[i] * x_before[i];
    const T own = own_gain[i] * x[i];
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      out[at] = next * q[at + 1] + last * q_before[at] - own * q[at];
    }
  }
}

/// Unit lengths for `count` links, and rates across them.
template <int kComponents, typename T>
[[gnu::always_inline]] inline void normalise_loop(std::size_t count, std::size_t n, T* __restrict q,
                                                  T* __restrict rate) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < count; ++i) {
    T square = {}, along = {};
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      square += q[at] * q[at];
      along += q[at] * rate[at];
    }
    const T scale = Element<T>(1) / square_root(square), radial = along / square;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      rate[at] = rate[at] - radial * q[at];
      q[at] = q[at] * scale;
    }
  }
}

/// Leaves of x what lies across the directions in `base`.
template <int kComponents, typename T>
[[gnu::always_inline]] inline void to_tangent_loop(std::size_t n, const T* __restrict base,
                                                   T* __restrict x) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    T along = {};
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      along += x[at] * base[at];
    }
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] = x[at] - along * base[at];
    }
  }
}

/// A link that is turned from its chart's base by almost a right angle has left the chart: it has
/// less than this of cosine squared.
inline constexpr double kLeastRoom = 1e-4;

/// x = its part across b + w b with w = sqrt(1 - |x|^2), and its rate; returns how many links have
/// left the chart, of numbers alone: lanes are looked at when all steps are taken.
template <int kComponents, typename T>
[[gnu::always_inline]] inline std::size_t retract_loop(std::size_t n, const T* __restrict base,
                                                       T* __restrict x, T* __restrict rate) {
  const T edge = T{} + Element<T>(kLeastRoom);
  std::size_t outside = 0;
#pragma GCC ivdep  // components do not overlap
  for (std::size_t i = 0; i < n; ++i) {
    T x_along = {}, rate_along = {};
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x_along += x[at] * base[at];
      rate_along += rate[at] * base[at];
    }
    T square = {}, product = {};
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] = x[at] - x_along * base[at];
      rate[at] = rate[at] - rate_along * base[at];
      square += x[at] * x[at];
      product += x[at] * rate[at];
    }
    const T room = Element<T>(1) - square;
    if constexpr (std::is_floating_point_v<T>) outside += room > edge ? 0 : 1;
    const T w = square_root(room > edge ? room : edge);
    const T fall = product / w;
    for (int c = 0; c < kComponents; ++c) {
      const std::size_t at = static_cast<std::size_t>(c) * n + i;
      x[at] = x[at] + w * base[at];
      rate[at] = rate[at] - fall * base[at];
    }
  }
  return outside;
}

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
