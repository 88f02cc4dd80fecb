// Arrays of numpy that show memory of a simulation.
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <vector>

#include "sim/motion/types.h"

namespace taut::python {

/// The arrays that show vectors of one object. The object may change, move and free them: before it
/// does, detach() leaves to each array the memory that it shows.
class Windows {
 public:
  /// The vectors as an array (n, 3), without a copy. `owner` keeps them.
  pybind11::array open(std::vector<Vec3>& vectors, std::shared_ptr<const void> owner,
                       bool writeable);

  /// From now on the arrays show what they show now, and the object has memory of its own. Costs
  /// nothing where no array is left.
  void detach();

 private:
  struct Window {
    std::vector<Vec3>* shown = nullptr;
    std::shared_ptr<const void> owner;
    std::vector<Vec3> kept = {};
  };
  std::vector<std::weak_ptr<Window>> open_;
};

}  // namespace taut::python
