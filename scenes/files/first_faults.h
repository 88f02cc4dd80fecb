// The faults that stand first in a file, so that a list of them has an end.
#pragma once

#include <cstddef>
#include <vector>

#include "scenes/files/fault.h"

namespace taut::scenes {

/// Keeps those that stand first; of the others only the number.
class FirstFaults {
 public:
  static constexpr std::size_t kMost = 100;

  void add(const SceneFault& fault);
  std::size_t count() const { return count_; }  // those left out, too

  /// At most kMost, in the order of the file.
  std::vector<SceneFault> list() &&;

 private:
  void keep_first();

  std::vector<SceneFault> kept_;
  std::size_t count_ = 0;
};

}  // namespace taut::scenes
