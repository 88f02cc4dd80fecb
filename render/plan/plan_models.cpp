#include "render/plan/plan_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "render/options/study_options.h"
#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/names.h"
#include "sim/motion/stop.h"
#include "sim/run/bodies_as_links.h"
#include "sim/run/coarser.h"
#include "sim/study/refined.h"
#include "sim/topology/span.h"

namespace taut::planning {
namespace {

/// Shares of the links that are tried.
std::vector<double> shares(std::size_t most_links) {
  std::vector<double> list{1};
  for (double share = 1; share * static_cast<double>(most_links) > 1; share /= 2) {
    for (const double eighths : {7.0, 6.0, 5.0, 4.0}) list.push_back(share * eighths / 8);
  }
  return list;
}

constexpr std::size_t kCopies = 4;  // of each connector that are looked at, besides itself

/// The bodies that can be links; all copies of a connector hang on their own bodies, or none does.
std::vector<std::size_t> possible_links(const World& world, const Timeline& timeline) {
  std::vector<std::size_t> bodies;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (why_no_link(world, timeline, b).empty()) bodies.push_back(b);
  }
  return bodies;
}

/// The model, and where bodies can be links also with all of these as links.
void add_with_links(const SceneModel& model, std::vector<SceneModel>& models) {
  models.push_back(model);
  SceneModel linked = model;
  for (const std::size_t b : possible_links(linked.model.world, linked.model.timeline)) {
    linked.model.world.bodies[b].model = BodyModel::link;
    linked.links.push_back(linked.model.world.bodies[b].name);
  }
  if (!linked.links.empty()) models.push_back(std::move(linked));
}

/// Whether what is numbered are copies, each a component of its own to which nothing else refers.
bool has_copies_alone(const World& world, const Timeline& timeline) {
  const auto names_numbered = [&](const auto& event) {
    return scenes::is_numbered(world.connectors[event.connector].name);
  };
  const auto has_winch = [](const Connector& connector) { return connector.winch != nullptr; };
  return world.joints.empty() && world.pulleys.empty() && world.bead_pairs.empty() &&
         std::ranges::none_of(world.connectors, has_winch) &&
         std::ranges::none_of(timeline.pins, names_numbered) &&
         std::ranges::none_of(timeline.cuts, names_numbered);
}

/// The scene with massless ropes over its pulleys, where some have mass; else without links, but
/// for what is joined, which has no spans. None where the scene's start needs what they leave out.
std::optional<SceneModel> massless_model(const scenes::Scene& scene,
                                         const std::vector<scenes::SceneChange>& written,
                                         SceneModel model) {
  if (const std::set<std::string> ropes = scenes::heavy_ropes(scene.world); !ropes.empty()) {
    std::vector<scenes::SceneChange> changes = written;
    for (const std::string& name : ropes) {
      model.particles[name] = 0;
      for (scenes::SceneChange& change : scenes::without_mass(name)) {
        changes.push_back(std::move(change));
      }
    }
    try {
      model.model.world = scenes::load_scene(scene.file, false, changes).world;
    } catch (const scenes::BadScene&) {
      return std::nullopt;
    }
    return model;
  }
  if (has_spans(scene.world) || !scene.world.joints.empty()) return std::nullopt;
  for (auto& [name, particles] : model.particles) particles = 0;
  model.neglected = physics_of(model.model.world);
  neglect(model.model.world, model.neglected);
  for (Connector& connector : model.model.world.connectors) {
    connector.model = ConnectorModel::span;
  }
  return model;
}

}  // namespace

std::vector<SceneModel> models_of(const scenes::Scene& scene,
                                  const std::vector<scenes::SceneChange>& written,
                                  const std::vector<Physics>& negligible) {
  std::size_t most = 1;
  for (const Connector& connector : scene.world.connectors) {
    most = std::max(most, connector.links());
  }
  std::vector<SceneModel> models;
  for (const double share : shares(most)) {
    std::map<std::string, std::size_t> particles;
    std::vector<scenes::SceneChange> changes = written;
    for (const Connector& connector : scene.world.connectors) {
      if (scenes::is_numbered(connector.name)) continue;
      const auto links = static_cast<std::size_t>(
          std::max(1.0, std::round(share * static_cast<double>(connector.links()))));
      particles[connector.name] = links + 1;
      changes.push_back(
          {fmt::format("connectors.{}.particles", connector.name), fmt::to_string(links + 1)});
    }
    if (!models.empty() && models.back().particles == particles) continue;
    try {
      scenes::Scene changed = scenes::load_scene(scene.file, false, changes);
      take_masses(changed.world, scene.world);
      SceneModel model{particles,
                       {},
                       {},
                       {few_copies(changed.world, changed.timeline), changed.timeline, {}},
                       {}};
      add_with_links(model, models);
      if (negligible.empty()) continue;
      model.neglected = negligible;
      neglect(model.model.world, negligible);
      add_with_links(model, models);
    } catch (const scenes::BadScene&) {
      // The scene's start, or one of its pins, needs more particles.
    }
  }
  if (auto massless = massless_model(scene, written, models.front())) {
    models.push_back(std::move(*massless));
  }
  return models;
}

bool is_massless(const SceneModel& model) {
  return std::ranges::any_of(model.particles, [](const auto& one) { return one.second == 0; });
}

ModelErrors model_errors(const scenes::Scene& scene,
                         const std::vector<scenes::SceneChange>& written,
                         const std::vector<SceneModel>& models,
                         const study::ReferenceSolution& reference, const MethodChoice& finely,
                         const study::Distance& distance, const study::TimeLeft& left) {
  ModelErrors errors;
  if (reference.known < 2) return errors;
  // Not a number where there is no time to know it.
  const auto off = [&](const World& world, const Timeline& timeline) {
    try {
      const double cap = left();
      return cap > 0 ? study::distance_between(reference, world, timeline, finely, distance, cap)
                     : NAN;
    } catch (const OverLimit&) {
      return double(NAN);
    }
  };
  const auto refined = [&](std::size_t times) {
    std::vector<scenes::SceneChange> changes = written;
    for (const Connector& connector : scene.world.connectors) {
      if (scenes::is_numbered(connector.name)) continue;
      changes.push_back({fmt::format("connectors.{}.particles", connector.name),
                         fmt::to_string(times * connector.links() + 1)});
    }
    // Nets have as many particles as their knots and links ask for.
    if (changes.size() == written.size()) return std::numeric_limits<double>::infinity();
    try {
      const scenes::Scene changed = scenes::load_scene(scene.file, false, changes);
      return off(few_copies(changed.world, changed.timeline), changed.timeline);
    } catch (const scenes::BadScene&) {
      return std::numeric_limits<double>::infinity();  // points were given for so many particles
    }
  };
  errors.twice = refined(2);
  errors.four = refined(4);
  errors.rope = study::error_of_chain(errors.twice, errors.four);
  for (const Physics one : physics_of(scene.world)) {
    World without = models.front().model.world;
    neglect(without, std::span(&one, 1));
    errors.physics[one] = off(without, models.front().model.timeline);
  }
  const SceneModel& last = models.back();
  if (is_massless(last)) {
    const double span = off(last.model.world, last.model.timeline);
    if (!std::isnan(span)) errors.span = span;
  }
  if (models.size() > 1 && !models[1].links.empty()) {
    const SceneModel& linked = models[1];
    const double link = off(linked.model.world, linked.model.timeline);
    if (!std::isnan(link)) errors.link = link;
  }
  return errors;
}

std::vector<Physics> negligible_physics(const scenes::Scene& scene,
                                        const study::ReferenceSolution& reference,
                                        const MethodChoice& finely,
                                        const study::Tolerance& tolerance, double cpu_cap) {
  std::vector<Physics> negligible;
  const std::vector<Physics> all = physics_of(scene.world);
  for (const Physics one : all) {
    std::vector<Physics> tried = negligible;
    tried.push_back(one);
    study::PlanModel model{few_copies(scene.world, scene.timeline), scene.timeline, {}};
    neglect(model.world, tried);
    const study::Trial trial =
        study::attempt(model, finely, reference, tolerance, INFINITY, cpu_cap / double(all.size()));
    if (trial.end == study::Trial::End::within) negligible = std::move(tried);
  }
  return negligible;
}

World few_copies(World world, const Timeline& timeline) {
  if (!has_copies_alone(world, timeline)) return world;
  std::map<std::string, std::size_t> copies, seen;
  const auto original = [](const Connector& connector) {
    return std::string(scenes::written_name(connector.name));
  };
  for (const Connector& connector : world.connectors) copies[original(connector)] += 1;
  const auto is_left_out = [&](const Connector& connector) {
    const std::size_t number = seen[original(connector)]++, count = copies[original(connector)];
    const bool on_body = std::ranges::any_of(
        connector.holds, [](const Hold& hold) { return hold.to.kind == Attachment::Kind::body; });
    if (on_body || count <= kCopies + 1) return false;
    // The first, the last, and some evenly between.
    const std::size_t before = number == 0 ? 0 : (number - 1) * kCopies / (count - 1);
    return number != 0 && number * kCopies / (count - 1) == before;
  };
  return with_change(std::move(world),
                     [&](World& some) { std::erase_if(some.connectors, is_left_out); });
}

std::vector<MethodChoice> all_candidates(const World& world, int fps, double longest_step) {
  std::vector<MethodChoice> all;
  for (const options::Contender& contender : options::chosen_contenders({})) {
    if (!follows(*contender.method, world)) continue;
    const std::vector<MethodChoice> some = options::candidates_of(contender, false);
    all.insert(all.end(), some.begin(), some.end());
  }
  for (MethodChoice& candidate : all) {
    const auto step = candidate.settings.find("step");
    if (step == candidate.settings.end()) continue;
    double& seconds = std::get<double>(step->second);
    if (seconds > 0) seconds = 1 / (fps * std::ceil(1 / (fps * seconds) - 1e-6));
  }
  std::erase_if(all, [&](const MethodChoice& candidate) {
    return step_of(candidate.settings) > longest_step;
  });
  // The one that is likely to be chosen first: what is dearer than its best is given up early.
  std::stable_partition(all.begin(), all.end(), [](const MethodChoice& candidate) {
    return candidate.name == scenes::default_method().name;
  });
  return all;
}

std::string describe(const SceneModel& model, const scenes::Scene& scene) {
  std::string text;
  for (const Connector& connector : scene.world.connectors) {
    if (scenes::is_numbered(connector.name)) continue;
    const std::size_t particles = model.particles.at(connector.name);
    if (particles == connector.particles()) continue;
    text += text.empty() ? "" : ", ";
    if (scene.world.connectors.size() > 1) text += connector.name + " ";
    text += particles == 0 ? "a massless span"
                           : fmt::format("{} of {} particles", particles, connector.particles());
  }
  for (const std::string& body : model.links) {
    text += fmt::format("{}{} a link", text.empty() ? "" : ", ", body);
  }
  for (const Physics one : model.neglected) {
    text += fmt::format("{}no {}", text.empty() ? "" : ", ", name_of(one));
  }
  return text.empty() ? "as it is written" : text;
}

}  // namespace taut::planning
