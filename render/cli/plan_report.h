// What taut plan says of the plan that it found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/cli/plan_models.h"
#include "sim/study/front.h"
#include "sim/study/planner.h"
#include "sim/truth/truth.h"

namespace taut::cli {

/// The tolerance as it was given.
struct Asked {
  Tolerance tolerance;
  std::string unit;      // "px" or "mm"
  double per_metre = 0;  // the most units that a metre has
};

/// What can be compared once motions are no longer predictable.
struct Afterwards {
  std::optional<double> energy;  // the largest change, of what the world can turn into motion
  double stretch = 0;            // the largest of a link
  Spread speeds, true_speeds;    // m/s, of all particles from the horizon on
};

/// A plan with everything that led to it.
struct Planned {
  const Scene& scene;
  const Asked& asked;
  const Truth& truth;
  const std::vector<SceneModel>& models;
  const Search& search;
  const Trial& best;
  Plan plan;
  Afterwards after;
  double work_as_written = 0, cost = 0, cost_as_written = 0, error_as_written = 0;

  const SceneModel& model() const { return models[best.model]; }
  const Candidate& candidate() const { return model().model.candidates[best.candidate]; }
};

/// A few lines, and the table of what was left out.
std::string plan_text(const Planned& planned);
/// The same as JSON.
std::string plan_json(const Planned& planned);

}  // namespace taut::cli
