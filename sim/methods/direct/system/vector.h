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

}  // namespace taut::direct
