// taut plan: the models to choose from, the search, and the report on the plan found.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/chart/table.h"
#include "render/program/output.h"
#include "scenes/scene/scene.h"
#include "sim/study/planner.h"

namespace taut::planning {

// The ways to model a scene that the planner chooses from.

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

// The report of taut plan on the plan that it found.

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

// The plans that scenes carry, side by side.

/// A row for each scene file: the tolerance asked for, the plan, and the accuracy that it keeps.
/// Throws BadScene.
chart::Table plan_table(const std::vector<std::string>& scenes);
/// The same as JSON, with all that plans hold.
program::Json plans_json(const std::vector<std::string>& scenes);

/// The cheapest model within the tolerance, at every frame and at all that the clip shows between
/// them. `changes` are those that the scene was read with, `tolerance` its words and `stamp` the
/// file's, as the plan keeps them. Takes about `budget` (s) of CPU time: what it left out for that
/// is in the result. Says how far it is unless `quiet`. Throws Misuse where no method comes so near
/// or the budget is too small to know.
Planned make_plan(const scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                  Asked asked, const std::string& tolerance, std::uint64_t stamp, double budget,
                  bool quiet);

}  // namespace taut::planning
