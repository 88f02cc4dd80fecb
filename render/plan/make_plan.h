// Finding the plan of a scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/plan/plan_report.h"

namespace taut::planning {

/// The cheapest model within the tolerance, at every frame and at all that the clip shows between
/// them. `changes` are those that the scene was read with, `tolerance` its words and `stamp` the
/// file's, as the plan keeps them. Takes about `budget` (s) of CPU time: what it left out for that
/// is in the result. Says how far it is unless `quiet`. Throws Misuse where no method comes so near
/// or the budget is too small to know.
Planned make_plan(const scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                  Asked asked, const std::string& tolerance, std::uint64_t stamp, double budget,
                  bool quiet);

}  // namespace taut::planning
