// Vector code for more than one kind of processor.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

// Compiles a function twice, for any x86-64 and for those with AVX2 and FMA, and chooses when the
// program starts. Only plain loops profit: functions they call must be inlined.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define TAUT_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define TAUT_VECTOR_CLONES
#endif

namespace taut::direct {

/// Numbers in the widest vector that loops are written for.
inline constexpr std::size_t kLanes = 4;

/// As many numbers at once, wherever they begin.
using Vector [[gnu::vector_size(kLanes * sizeof(double)), gnu::aligned(8), gnu::may_alias]] =
    double;

/// The largest |x| of n numbers, a multiple of kLanes, each times its scale; NaN does not count. By
/// hand, since without -ffast-math compilers keep to the order.
template <typename... Scale>
[[gnu::always_inline]] inline double largest(std::size_t n, const double* x,
                                             const Scale*... scale) {
  const auto at = [](const double* array, std::size_t i) -> const Vector& {
    return *reinterpret_cast<const Vector*>(array + i);
  };
  Vector most{};
  for (std::size_t i = 0; i < n; i += kLanes) {
    const Vector size = ((at(x, i) < 0 ? -at(x, i) : at(x, i)) * ... * at(scale, i));
    most = size > most ? size : most;
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

/// Begins a cache line, so that no vector lies across two.
template <typename T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  LineAllocator() = default;
  template <typename U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kLine)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kLine); }
  bool operator==(const LineAllocator&) const = default;
};

using Array = std::vector<double, LineAllocator<double>>;

// Sines and cosines in loops that the compiler can turn into vector code.

struct SinCos {
  double sine, cosine;
};

/// Both to some 2e-16, for |angle| up to 1e6 or so. With r the angle less the nearest multiple of
/// pi, |r/2| <= pi/4, sine and cosine of r/2 follow from Taylor's series, and of r from those.
[[gnu::always_inline]] inline SinCos sine_and_cosine(double angle) {
  // Adding and subtracting 1.5 * 2^52 rounds to a whole number.
  constexpr double kRound = 6755399441055744.0;
  constexpr double kInversePi = 0.3183098861837907;
  constexpr double kPi = 3.141592653589793, kPiRest = 1.2246467991473532e-16;
  const double turns = (angle * kInversePi + kRound) - kRound;
  const double pairs = (0.5 * turns + kRound) - kRound;
  const double odd = turns - 2 * pairs;  // -1, 0 or 1
  const double sign = 1 - 2 * odd * odd;
  const double x = 0.5 * ((angle - turns * kPi) - turns * kPiRest), y = x * x;
  constexpr double s3 = -1.0 / 6, s5 = 1.0 / 120, s7 = -1.0 / 5040, s9 = 1.0 / 362880;
  constexpr double s11 = -1.0 / 39916800, s13 = 1.0 / 6227020800, s15 = -1.0 / 1307674368000;
  constexpr double c4 = 1.0 / 24, c6 = -1.0 / 720, c8 = 1.0 / 40320, c10 = -1.0 / 3628800;
  constexpr double c12 = 1.0 / 479001600, c14 = -1.0 / 87178291200;
  constexpr double c16 = 1.0 / 20922789888000;
  const double s =
      x + x * y * (s3 + y * (s5 + y * (s7 + y * (s9 + y * (s11 + y * (s13 + y * s15))))));
  const double c =
      1 + y * (-0.5 + y * (c4 + y * (c6 + y * (c8 + y * (c10 + y * (c12 + y * (c14 + y * c16)))))));
  return {2 * sign * s * c, sign * (1 - 2 * s * s)};
}

}  // namespace taut::direct
