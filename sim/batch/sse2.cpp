// Four vectors of 4 floats or 2 doubles side by side.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

constexpr std::size_t kGroups = 4;

using Floats [[gnu::vector_size(16)]] = float;
using Doubles [[gnu::vector_size(16)]] = double;

}  // namespace

Kernel<float> sse2_float() {
  return {kGroups * 16 / sizeof(float),
          [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats, kGroups>(links, group, steps);
          }};
}

Kernel<double> sse2_double() {
  return {kGroups * 16 / sizeof(double),
          [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles, kGroups>(links, group, steps);
          }};
}

}  // namespace taut::batch
