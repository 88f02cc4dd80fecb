#include "scenes/files/error.h"

#include <algorithm>
#include <tuple>

namespace taut::scenes {

void FirstFaults::add(const SceneFault& fault) {
  ++count_;
  kept_.push_back(fault);
  if (kept_.size() >= 2 * kMost) keep_first();
}

void FirstFaults::keep_first() {
  std::ranges::stable_sort(kept_, {}, [](const SceneFault& fault) {
    return std::tuple(fault.place.line, fault.place.column);
  });
  if (kept_.size() > kMost) kept_.erase(kept_.begin() + kMost, kept_.end());
}

std::vector<SceneFault> FirstFaults::list() && {
  keep_first();
  return std::move(kept_);
}

}  // namespace taut::scenes
