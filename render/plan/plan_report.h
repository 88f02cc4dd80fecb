// The report of taut plan on the plan that it found.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/plan/plan_models.h"
#include "sim/study/planner.h"

namespace taut::planning {

/// The tolerance as it was given.
struct Asked {
  study::Tolerance tolerance;
  std::string unit;      // "px" or "mm"
  double per_metre = 0;  // the most units that a metre has
};

/// The clip's motion blur.
struct Blur {
  double way = 0;    // px, the most that a point comes while the shutter is open
  int most = 1;      // exposures of a frame
  double apart = 0;  // px, the most that a point comes from one to the next
  double mean = 0, mean_as_written = 0;  // exposures of a frame, by the plan and without
  double longest_step = INFINITY;        // s, of methods that have as many states to show
};

/// A plan with everything that led to it.
struct Planned {
  scenes::Scene scene;
  Asked asked;
  study::ReferenceSolution reference;
  std::vector<SceneModel> models;
  study::Search search;
  study::Trial best;
  scenes::Plan plan = {};
  double scored = 0;  // m, the tolerance
  ModelErrors models_off = {};
  std::optional<Blur> blur = {};          // where there is a shutter
  std::optional<double> clip_error = {};  // at what the clip shows between frames
  double error = 0;                       // the largest of all that is compared
  study::Trial as_written = {};           // run to its end, whatever its error
  double cost = 0, cost_as_written = 0;   // measured: CPU s per simulated second; NAN: not
  std::size_t left_out = 0;               // models and settings not run to their end, for want of
  double budget = 0;                      // s of CPU time

  const SceneModel& model() const { return models[best.model]; }
  const MethodChoice& candidate() const { return model().model.candidates[best.candidate]; }
};

/// The outcome of a candidate, in a few words.
std::string outcome(const study::Trial& trial, const Asked& asked,
                    const study::ReferenceSolution& reference);
/// The trial that came nearest to being chosen: the cheapest within, else the cheapest of those
/// that were only too dear, else one that only differs later, else the least error; of one method
/// where that is named.
const study::Trial* nearest(const study::Search& search, const std::vector<SceneModel>& models,
                            std::string_view method = {});

/// A few lines, and the table of what was left out.
std::string plan_text(const Planned& planned);
/// The same as JSON.
std::string plan_json(const Planned& planned);

}  // namespace taut::planning
