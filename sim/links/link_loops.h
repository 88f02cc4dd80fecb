// The loops over links: of one connector, or of many side by side, a lane each. No function of the
// standard library is used, nor one that is not always inlined: see sim/batch.
#pragma once

#include <cstddef>
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

}  // namespace taut
