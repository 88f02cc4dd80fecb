#include "sim/batch/width.h"

#include <type_traits>

namespace taut::batch {

Width widest() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) return Width::avx512;
  if (__builtin_cpu_supports("avx2")) return Width::avx2;
#endif
  return Width::sse2;  // 16 bytes: every 64-bit processor has vectors of these
}

template <typename Scalar>
Kernel<Scalar> kernel(Width width) {
  [[maybe_unused]] constexpr bool kFloat = std::is_same_v<Scalar, float>;
  switch (width) {
    case Width::single:
      break;
    case Width::sse2:
      if constexpr (kFloat)
        return sse2_float();
      else
        return sse2_double();
    case Width::avx2:
      if constexpr (kFloat)
        return avx2_float();
      else
        return avx2_double();
    case Width::avx512:
      if constexpr (kFloat)
        return avx512_float();
      else
        return avx512_double();
  }
  if constexpr (kFloat)
    return single_float();
  else
    return single_double();
}

template Kernel<float> kernel(Width width);
template Kernel<double> kernel(Width width);

}  // namespace taut::batch
