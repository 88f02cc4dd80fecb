// The paper's one number on cost, "2.76 times faster than the particle system": under which
// settings it appears, and what it is at equal error.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sim/evaluation/run.h"
#include "sim/truth/truth.h"

namespace taut::study {

inline constexpr double kPaperRatio = 2.76;  // the particle system's time over the paper's method's

/// A particle system that costs kPaperRatio times as much as the paper's method.
struct PaperSetting {
  std::size_t particles = 0;
  double impulse_steps = 0;       // per frame
  double impulse_cost = 0;        // CPU s per frame
  double impulse_error = 0;       // RMS, share of the length
  double substeps = 0;            // of the springs, per frame
  double stiffness = 0;           // N/m, the hardest that these steps bear
  double ratio = 0;               // as measured
  double error = 0, stretch = 0;  // of the springs; shares of the length and of a link
};

/// The cost of a method where its error equals the paper's method's at one of its own settings.
struct EqualError {
  std::size_t particles = 0;
  double error = 0;         // RMS, share of the length
  std::string method;       // entrant's label
  double impulse_cost = 0;  // CPU s per simulated second
  double cost = 0;          // the same of `method`, between its two nearest settings or, where all
                            // are nearer to the truth, of the cheapest; 0: not reached
};

struct PaperRatio {
  double horizon = 0;  // s, of the errors
  std::vector<PaperSetting> settings;
  std::vector<EqualError> equal;
};

/// A method or a form of it, and the settings that are tried, cheap to dear.
struct Entrant {
  std::string label;
  const MethodInfo* method = nullptr;
  std::vector<MethodChoice> candidates;
};

/// Measures both on a problem of frames of `frame` (s) up to the reference's horizon. `seconds`:
/// about how long it may take. Empty where the entrants lack one of the two methods. Calls `tick`
/// between runs; it may throw to stop.
PaperRatio paper_ratio(const Problem& problem, const truth::Reference& reference, double frame,
                       std::span<const Entrant> entrants, double seconds,
                       const std::function<void()>& tick);

}  // namespace taut::study
