// A method that runs beside another, coarser as a rule, whose error is a known multiple.
#pragma once

#include "sim/run/method.h"

namespace taut {

/// What runs beside a method so that the difference tells the error: see ErrorEstimate.
struct Companion {
  std::unique_ptr<Method> method = nullptr;  // null: there is none
  /// How many times as large its error is (less than once where it is the finer one) or, where that
  /// is zero, the power of how many times as long its steps are.
  double ratio = 0, order = 0;
  /// Its steps are as many times as short as n + 1 is more than n, those that end with a frame,
  /// too: it gets over n frames in n + 1 equal parts. Zero: it sees the frames that the run sees.
  int frames = 0;
  /// Tells it what the run has done since it was told last; null: it need not know.
  void (*heed)(Method& companion, const Method& run) = nullptr;
  double asked = 0;            // m, the error that the settings ask for; 0: they name none
  std::string_view none = {};  // why there is none, to be read after the method's name
};

/// With the tolerance of this name 4 times as large, or as large as it can be, and an error in
/// proportion. None where it cannot be even twice as large. A tolerance in metres is what is asked.
Companion with_tolerance_raised(const MethodInfo& method, Settings settings,
                                std::string_view tolerance);

/// With steps twice as long, for methods of equal steps of the setting `step` and an error in
/// proportion to its power `order`.
Companion with_step_doubled(const MethodInfo& method, Settings settings, double order);

}  // namespace taut
