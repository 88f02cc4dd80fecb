// Four single numbers side by side.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

constexpr std::size_t kSingles = 4;

}  // namespace

Kernel<float> single_float() {
  return {kSingles, [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<float, kSingles>(links, group, steps);
          }};
}

Kernel<double> single_double() {
  return {kSingles, [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<double, kSingles>(links, group, steps);
          }};
}

}  // namespace taut::batch
