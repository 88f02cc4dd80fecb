// Vectors of 16 floats or 8 doubles.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

using Floats [[gnu::vector_size(64)]] = float;
using Doubles [[gnu::vector_size(64)]] = double;

}  // namespace

Kernel<float> avx512_float() {
  return {64 / sizeof(float), [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats>(links, group, steps);
          }};
}

Kernel<double> avx512_double() {
  return {64 / sizeof(double), [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles>(links, group, steps);
          }};
}

}  // namespace taut::batch
