// Single numbers, for processors without vectors and for tests.
#include "sim/batch/width.h"

namespace taut::batch {

Kernel<float> single_float() {
  return {1, [](std::size_t links, void* group, const Steps<float>& steps) {
            advance_group<float>(links, group, steps);
          }};
}

Kernel<double> single_double() {
  return {1, [](std::size_t links, void* group, const Steps<double>& steps) {
            advance_group<double>(links, group, steps);
          }};
}

}  // namespace taut::batch
