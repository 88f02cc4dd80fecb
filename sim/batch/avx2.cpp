// Four vectors of 8 floats or 4 doubles side by side.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

constexpr std::size_t kGroups = 4;

using Floats [[gnu::vector_size(32)]] = float;
using Doubles [[gnu::vector_size(32)]] = double;

}  // namespace

Kernel<float> avx2_float() {
  return {kGroups * 32 / sizeof(float),
          [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats, kGroups>(links, group, steps);
          }};
}

Kernel<double> avx2_double() {
  return {kGroups * 32 / sizeof(double),
          [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles, kGroups>(links, group, steps);
          }};
}

}  // namespace taut::batch
