// The ways to model a scene that the planner chooses from.
#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/study/planner.h"

namespace taut::planning {

struct SceneModel {
  std::map<std::string, std::size_t> particles;  // of each connector, as Plan has them
  std::vector<std::string> links;                // bodies that are links, as Plan has them
  std::vector<Physics> neglected;                // as Plan has it
  study::PlanModel model;                        // with every method's settings as candidates
  study::Trial alone;                            // the model's own error: solved finely
};

/// The scene as it is written, then with fewer and fewer particles: of each connector about 7/8,
/// 3/4, 5/8, 1/2 of its links, the same shares of the half and so on, down to one; each of these
/// also with links for all bodies that can be links, and each without `negligible` physics; and as
/// massless spans, or with massless ropes over pulleys. Candidates and trials are not yet set.
/// `written` are the changes that the scene was read with.
std::vector<SceneModel> models_of(const scenes::Scene& scene,
                                  const std::vector<scenes::SceneChange>& written,
                                  const std::vector<Physics>& negligible);

/// The physics of the scene's connectors that may be left out together: each in turn, solved by
/// `finely`, changes no point by more than the tolerance. Physics whose run would exceed its share
/// of `cpu_cap` (s) are kept.
std::vector<Physics> negligible_physics(const scenes::Scene& scene,
                                        const study::ReferenceSolution& reference,
                                        const MethodChoice& finely,
                                        const study::Tolerance& tolerance, double cpu_cap);

/// Every method that follows the world, at every setting of its sweep, with steps that divide a
/// frame of 1/`fps` s and are at most `longest_step` (s); the default method first.
std::vector<MethodChoice> all_candidates(const World& world, int fps,
                                         double longest_step = INFINITY);

/// The errors of models, whatever solves them, in the tolerance's unit.
struct ModelErrors {
  double twice = 0, four = 0;  // by how much the scene's chains differ from 2 and 4 times the links
  std::optional<double> rope;  // from continuous ropes, where these tell
  std::optional<double> span;  // of what is massless from the scene's chains
  std::optional<double> link;  // of links in the place of rigid bodies
  std::map<Physics, double> physics;  // of leaving one alone out
};

/// Solves the refined models by `finely`. A motion that is not predictable has no such errors;
/// those that there is no time for are not numbers.
ModelErrors model_errors(const scenes::Scene& scene,
                         const std::vector<scenes::SceneChange>& written,
                         const std::vector<SceneModel>& models,
                         const study::ReferenceSolution& reference, const MethodChoice& finely,
                         const study::Distance& distance, const study::TimeLeft& left);

/// Whether the model has something massless.
bool is_massless(const SceneModel& model);

/// The world with a few of each connector's copies: as they are all alike, these show for all how
/// good a model is. Copies that hang on bodies all stay, and all where something refers to some.
World few_copies(World world, const Timeline& timeline);

/// "6 of 11 particles"; "as it is written".
std::string describe(const SceneModel& model, const scenes::Scene& scene);

}  // namespace taut::planning
