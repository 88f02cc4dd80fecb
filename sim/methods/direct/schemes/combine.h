// Sums of stages with the weights of a tableau.
#pragma once

#include <cstddef>

namespace taut::direct {

/// sum_k kRow[k] stage_k[i] over the first kCount stages whose weight is not zero, known when
/// compiled.
template <auto kRow, int kCount, int k = 0>
[[gnu::always_inline]] inline double combine(const double* const* stage, std::size_t i) {
  if constexpr (k == kCount) {
    return 0;
  } else if constexpr (kRow[k] == 0) {
    return combine<kRow, kCount, k + 1>(stage, i);
  } else {
    return kRow[k] * stage[k][i] + combine<kRow, kCount, k + 1>(stage, i);
  }
}

}  // namespace taut::direct
