// Methods on one scene, run and measured for a film that shows them together.
#pragma once

#include <vector>

#include "render/film/comparison.h"
#include "render/options/study_options.h"

namespace taut::clips {

/// Solves the truth at the scene's frames, runs every contender at its settings or, where they are
/// of its method, the scene's, and measures how far each is from the truth and from dynamic
/// constraints, as the paper's Figure 6 does.
film::Comparison compare_methods(const scenes::Scene& scene,
                                 const std::vector<options::Contender>& contenders, bool quiet);

}  // namespace taut::clips
