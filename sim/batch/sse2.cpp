// Vectors of 4 floats or 2 doubles.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

using Floats [[gnu::vector_size(16)]] = float;
using Doubles [[gnu::vector_size(16)]] = double;

}  // namespace

Kernel<float> sse2_float() {
  return {16 / sizeof(float), [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats>(links, group, steps);
          }};
}

Kernel<double> sse2_double() {
  return {16 / sizeof(double), [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles>(links, group, steps);
          }};
}

}  // namespace taut::batch
