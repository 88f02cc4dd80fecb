// Two vectors of 16 floats or 8 doubles side by side.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

constexpr std::size_t kGroups = 2;

using Floats [[gnu::vector_size(64)]] = float;
using Doubles [[gnu::vector_size(64)]] = double;

}  // namespace

Kernel<float> avx512_float() {
  return {kGroups * 64 / sizeof(float),
          [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<Floats, kGroups>(links, group, steps);
          }};
}

Kernel<double> avx512_double() {
  return {kGroups * 64 / sizeof(double),
          [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<Doubles, kGroups>(links, group, steps);
          }};
}

}  // namespace taut::batch
