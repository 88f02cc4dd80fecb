// Methods with coarser settings, whose error is a known multiple of what it was.
#pragma once

#include "sim/method.h"

namespace taut {

/// A method made coarser, and how much larger its error is: `ratio` times or, where that is zero,
/// the power `order` of how many times as long its steps are.
struct CoarseMethod {
  std::unique_ptr<Method> method = nullptr;  // null: there is none
  double ratio = 0;
  double order = 0;
  double asked = 0;            // m, the error that the settings ask for; 0: they name none
  std::string_view none = {};  // why there is none, to be read after the method's name
};

/// With the tolerance of this name 4 times as large, or as large as it can be, and an error in
/// proportion. None where it cannot be even twice as large. A tolerance in metres is what is asked.
CoarseMethod with_tolerance_raised(const MethodInfo& method, Settings settings,
                                   std::string_view tolerance);

/// With steps twice as long, for methods of equal steps of the setting `step` and an error in
/// proportion to its power `order`.
CoarseMethod with_step_doubled(const MethodInfo& method, Settings settings, double order);

}  // namespace taut
