// Vectors of 8 floats or 4 doubles.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

using Floats [[gnu::vector_size(32)]] = float;
using Doubles [[gnu::vector_size(32)]] = double;

}  // namespace

Kernel<float> avx2_float() {
  return {32 / sizeof(float), [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats>(links, group, steps);
          }};
}

Kernel<double> avx2_double() {
  return {32 / sizeof(double), [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles>(links, group, steps);
          }};
}

}  // namespace taut::batch
