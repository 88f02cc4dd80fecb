// A method that runs beside another, coarser as a rule, whose error is a known multiple.
#pragma once

#include "sim/run/method.h"

namespace taut {

/// A method that runs beside another so that the difference tells the error: see ErrorEstimate.
struct Companion {
  std::unique_ptr<Method> method = nullptr;  // null: there is none
  /// `ratio`: its error over the run's (less than 1 where it is the finer one). Where that is zero,
  /// `order`: the error grows with this power of the steps' length.
  double ratio = 0, order = 0;
  /// The companion divides so many frames into one part more, all equal, so that its steps are
  /// shorter in that ratio. Zero: it sees the frames that the run sees.
  int frames = 0;
  /// Tells the companion what the run has done since the last call; null: it need not know.
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
