// Four single numbers side by side.
#include "sim/batch/width.h"

namespace taut::batch {
namespace {

constexpr std::size_t kGroups = 4;

}  // namespace

Kernel<float> single_float() {
  return {kGroups, [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<float, kGroups>(links, group, steps);
          }};
}

Kernel<double> single_double() {
  return {kGroups, [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<double, kGroups>(links, group, steps);
          }};
}

}  // namespace taut::batch
