// The widths of vectors that groups come in, and the kernels for them.
#pragma once

#include "sim/batch/kernel.h"

namespace taut::batch {

/// The widths that processors have; wider ones have the narrower ones too.
enum class Width { single, sse2, avx2, avx512 };

/// The widest of this processor.
Width widest();

template <typename Scalar>
struct Kernel {
  std::size_t lanes = 1;
  void (*advance)(std::size_t links, void* group, const Steps<Scalar>& steps) = nullptr;
};

/// For float and double. The processor must have the width.
template <typename Scalar>
Kernel<Scalar> kernel(Width width);

// Kernels, each in a file compiled for its instructions.
Kernel<float> single_float();
Kernel<double> single_double();
Kernel<float> sse2_float();
Kernel<double> sse2_double();
Kernel<float> avx2_float();
Kernel<double> avx2_double();
Kernel<float> avx512_float();
Kernel<double> avx512_double();

}  // namespace taut::batch
