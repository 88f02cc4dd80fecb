// The paper's one number on cost, "2.76 times faster than the particle system": under which
// settings it appears, and what it is at equal error.
#pragma once

#include <string>
#include <vector>

#include "render/options/study_options.h"

namespace taut::studies {

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

/// What a method costs where it is as wrong as the paper's method at one of its own settings.
struct EqualError {
  std::size_t particles = 0;
  double error = 0;         // RMS, share of the length
  std::string method;       // contender's label
  double impulse_cost = 0;  // CPU s per simulated second
  double cost = 0;          // the same of `method`, between its two nearest settings or, where all
                            // are nearer to the truth, of the cheapest; 0: not reached
};

struct PaperRatio {
  double horizon = 0;  // s, of the errors
  std::vector<PaperSetting> settings;
  std::vector<EqualError> equal;
};

/// Measures both at one number of particles, over the first `duration` seconds of the scene.
/// `seconds`: about how long it may take. Empty where the contenders lack one of the two methods.
PaperRatio paper_ratio(const options::StudyOptions& options,
                       const std::vector<options::Contender>& contenders, std::size_t particles,
                       double duration, double seconds);

chart::Table settings_table(const std::vector<PaperRatio>& all);
chart::Table equal_error_table(const std::vector<PaperRatio>& all);

}  // namespace taut::studies
