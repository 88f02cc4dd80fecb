// The ways to model a scene that the planner chooses from.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "sim/study/planner.h"

namespace taut::cli {

struct SceneModel {
  std::map<std::string, std::size_t> particles;  // of each connector
  PlanModel model;                               // with every method's settings as candidates
  Trial alone;                                   // the model's own error: solved finely
};

/// The scene as it is written, then with fewer and fewer particles: of each connector about 7/8,
/// 3/4, 5/8, 1/2 of its links, the same shares of the half and so on, down to one. Candidates and
/// trials are not yet set.
std::vector<SceneModel> models_of(const Scene& scene);

/// Every method at every setting of its sweep, with steps that divide a frame of 1/`fps` s; the
/// default method first.
std::vector<Candidate> all_candidates(int fps);

/// The world with a few of each connector's copies: as they are all alike, these show for all how
/// good a model is. Copies that hang on bodies all stay.
World few_copies(World world);

/// "6 of 11 particles"; "as it is written".
std::string describe(const SceneModel& model, const Scene& scene);

}  // namespace taut::cli
