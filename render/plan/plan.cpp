#include "render/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "render/base/child.h"
#include "render/base/interrupt.h"
#include "render/chart/table.h"
#include "render/draw/motion_extents.h"
#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"
#include "scenes/scene/clip.h"
#include "scenes/scene/scene.h"
#include "sim/motion/printable.h"
#include "sim/motion/side_by_side.h"
#include "sim/motion/stop.h"
#include "sim/run/reduced.h"
#include "sim/study/planner.h"
#include "sim/study/speed_accuracy.h"
#include "sim/topology/components.h"

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

namespace {

/// A cycle of the counts takes so long on a core of 3 GHz.
double milliseconds(double cycles) {
  return cycles / 3e6;
}

/// Models beyond the tolerance however well they are solved, and of every other method what came
/// nearest to being chosen.
chart::Table left_out(const Planned& planned) {
  chart::Table table{{"model", "method", "outcome"}, {}};
  bool plain_is_good = true;  // of the model before with the same particles and rigid bodies
  for (const SceneModel& model : planned.models) {
    if (model.links.empty()) plain_is_good = !model.model.candidates.empty();
    if (!model.model.candidates.empty() || (!model.links.empty() && !plain_is_good)) continue;
    table.add({describe(model, planned.scene), "any",
               outcome(model.alone, planned.asked, planned.reference)});
  }
  for (const MethodInfo& method : all_methods()) {
    if (method.name == planned.candidate().name) continue;
    const study::Trial* trial = nearest(planned.search, planned.models, method.name);
    if (!trial) continue;
    const SceneModel& model = planned.models[trial->model];
    table.add({describe(model, planned.scene), describe(model.model.candidates[trial->candidate]),
               outcome(*trial, planned.asked, planned.reference)});
  }
  return table;
}

std::string times_less(double before, double now) {
  return now <= before ? fmt::format("{} times less", options::rounded(before / now))
                       : fmt::format("{} times more", options::rounded(now / before));
}

/// The check of the reference solution, in words.
std::string checked_by(const study::ReferenceSolution& reference) {
  const std::string itself = "direct, ten times as finely";
  if (reference.checked < 2) return "checked by " + itself;
  if (reference.checked == reference.known) return "checked by truth";
  return fmt::format("checked by truth until {} s, then by {}",
                     options::rounded(reference.problem.times[reference.checked - 1]), itself);
}

/// The model of each free body, in words.
std::string bodies_text(const Planned& planned) {
  const World& reference = planned.scene.world;
  const World& world = planned.model().model.world;
  const std::vector<std::string>& links = planned.model().links;
  const MethodInfo& method = *find_method(planned.candidate().name);
  const std::vector<bool> as_links = method.steps_as_links && !has_spans(world)
                                         ? method.steps_as_links(world)
                                         : std::vector<bool>(world.bodies.size());
  std::string text;
  for (std::size_t b = 0; b < reference.bodies.size(); ++b) {
    const Body& body = reference.bodies[b];
    if (body.driven()) continue;
    const std::string reason = why_no_link(reference, planned.scene.timeline, b);
    std::string is = "a rigid body";
    if (std::ranges::find(links, body.name) != links.end()) {
      is = "one more link of its chain";
    } else if (as_links[b]) {
      is = fmt::format("a rigid body, which {} steps as one more link, exactly, while in a plane",
                       method.name);
    } else if (!reason.empty()) {
      is += fmt::format(" ({}: it cannot be a link)", reason);
    } else {
      is += ", as a link would be no cheaper";
    }
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", body.name, is);
  }
  if (const auto& off = planned.models_off.link) {
    text +=
        fmt::format("; links for bodies are {} {} off", options::rounded(*off), planned.asked.unit);
  }
  return text;
}

std::string clip_text(const Planned& planned) {
  return planned.clip_error ? fmt::format(", and {} {} at what the clip shows between them",
                                          options::rounded(*planned.clip_error), planned.asked.unit)
                            : "";
}

}  // namespace

std::string outcome(const study::Trial& trial, const Asked& asked,
                    const study::ReferenceSolution& reference) {
  const std::string& unit = asked.unit;
  const study::Difference &later = trial.later, &most = reference.most;
  switch (trial.end) {
    case study::Trial::End::within:
      return fmt::format("{} {} off", options::rounded(trial.error), unit);
    case study::Trial::End::beyond:
      return fmt::format("at least {} {} off", options::rounded(trial.error), unit);
    case study::Trial::End::unlike:
      if (later.energy > most.energy)
        return fmt::format("energy off by {}%", options::rounded(100 * later.energy));
      if (later.stretch > most.stretch)
        return fmt::format("stretches by {}%", options::rounded(100 * later.stretch));
      return fmt::format("other speeds of {}% of the points", options::rounded(100 * later.speeds));
    case study::Trial::End::dearer:
      return fmt::format("dearer: at least {} ms per simulated second",
                         options::rounded(milliseconds(trial.cycles)));
    case study::Trial::End::diverged:
      return "cannot run it";
    case study::Trial::End::cut:
      return "not run to its end: over the budget";
  }
  return "";
}

const study::Trial* nearest(const study::Search& search, const std::vector<SceneModel>& models,
                            std::string_view method) {
  const auto rank = [](const study::Trial& trial) {
    const bool by_cycles =
        trial.end == study::Trial::End::within || trial.end == study::Trial::End::dearer;
    return std::tuple(trial.end, by_cycles ? trial.cycles : trial.error);
  };
  const study::Trial* best = nullptr;
  for (const study::Trial& trial : search.trials) {
    const MethodChoice& candidate = models[trial.model].model.candidates[trial.candidate];
    if (!method.empty() && candidate.name != method) continue;
    if (!best || rank(trial) < rank(*best)) best = &trial;
  }
  return best;
}

std::string plan_text(const Planned& planned) {
  const scenes::Scene& scene = planned.scene;
  const study::ReferenceSolution& reference = planned.reference;
  const study::Trial& best = planned.best;
  const std::string& unit = planned.asked.unit;
  std::string text =
      fmt::format("{}: {}\n", scene.file.string(), scenes::certificate(planned.plan));
  const auto line = [&](const char* what, const std::string& is) {
    text += fmt::format("  {:<10}{}\n", what, printable(is));
  };
  line("model", describe(planned.model(), scene));
  line("method", describe(planned.candidate()));
  if (const std::string bodies = bodies_text(planned); !bodies.empty()) line("bodies", bodies);
  if (reference.known > 1) {
    line("error",
         fmt::format("{} {} at most, of every particle and the ends of every body in {} "
                     "frames{}",
                     options::rounded(best.error), unit, reference.known, clip_text(planned)));
    line("reference", fmt::format("known to {} {}: {}",
                                  options::rounded(planned.asked.per_metre * reference.self_error),
                                  unit, checked_by(reference)));
  } else {
    line("error",
         fmt::format("the motion is not predictable to {}: a nudge of a ten-thousandth of that "
                     "grows beyond a hundredth within a frame",
                     planned.plan.tolerance));
  }
  if (reference.known > 1 && reference.goes_on()) {
    line("until", fmt::format("{} s: {}a nudge of a ten-thousandth of {} then grows beyond a "
                              "hundredth of it",
                              options::rounded(planned.plan.until),
                              planned.plan.end.empty() ? "" : planned.plan.end + ", and ",
                              planned.plan.tolerance));
  }
  if (reference.goes_on()) {
    line("later",
         fmt::format(
             "{}energy{} within {}% of what lifts all by the length, and of all motion "
             "({}% would do)",
             reference.balanced ? "" : "mean ",
             reference.closed || !reference.balanced ? "" : ", less the work of what drives it,",
             options::rounded(100 * best.later.energy),
             options::rounded(100 * reference.most.energy)));
    line("", fmt::format("links within {}% of their length ({}%)",
                         options::rounded(100 * best.later.stretch),
                         options::rounded(100 * reference.most.stretch)));
    line("", fmt::format("speeds of all points distributed within {}% ({}%, by how much reference "
                         "solutions differ)",
                         options::rounded(100 * best.later.speeds),
                         options::rounded(100 * reference.most.speeds)));
  }
  const ModelErrors& off = planned.models_off;
  for (const auto& [physics, error] : off.physics) {
    const bool neglected = std::ranges::count(planned.model().neglected, physics) > 0;
    line(std::string(name_of(physics)).c_str(),
         fmt::format("without it the motion is {} {} off: {}", options::rounded(error), unit,
                     neglected ? "neglected" : "kept"));
  }
  if (off.rope) {
    line("rope", fmt::format("the scene's chains are {} {} from continuous ropes, as {} and {} {} "
                             "from twice and four times the links tell",
                             options::rounded(*off.rope), unit, options::rounded(off.twice),
                             options::rounded(off.four), unit));
  } else if (reference.known > 1 && std::isfinite(off.twice)) {
    line("rope", fmt::format("the scene's chains are {} and {} {} from twice and four times the "
                             "links: too few to tell where continuous ropes would be",
                             options::rounded(off.twice), options::rounded(off.four), unit));
  }
  if (off.span) {
    line("span", fmt::format("massless spans are {} {} from the scene's chains{}",
                             options::rounded(*off.span), unit,
                             off.rope ? fmt::format(", so at most {} {} from continuous ropes",
                                                    options::rounded(*off.span + *off.rope), unit)
                                      : ""));
  }
  if (const auto& blur = planned.blur) {
    line("blur", fmt::format("{} exposures of a frame at most, {} on average ({} as it is "
                             "written): the fastest point comes {} px while the shutter is open, "
                             "{} px from one to the next{}",
                             blur->most, options::rounded(blur->mean),
                             options::rounded(blur->mean_as_written), options::rounded(blur->way),
                             options::rounded(blur->apart),
                             blur->most < scenes::kMostStates
                                 ? ""
                                 : fmt::format("; more change no pixel by more "
                                               "than 1/{} of its contrast",
                                               scenes::kMostStates)));
  }
  if (planned.as_written.end == study::Trial::End::diverged) {
    line("saving", fmt::format("as it is written, {} diverges", describe(scene.method)));
  } else if (planned.as_written.end == study::Trial::End::cut) {
    line("saving", fmt::format("not known: as it is written, {} is not run to its end within the "
                               "budget",
                               describe(scene.method)));
  } else {
    const double measured = planned.cost_as_written / planned.cost;
    line("saving",
         fmt::format(
             "{} by counted work, {} measured, than as it is written: {}, {} {} off",
             times_less(planned.as_written.cycles, best.cycles),
             std::isnan(measured) ? "not" : times_less(planned.cost_as_written, planned.cost),
             describe(scene.method), options::rounded(planned.as_written.error), unit));
  }
  line("cost",
       fmt::format("{} ms of CPU time per simulated second predicted from the counts, {} measured",
                   options::rounded(milliseconds(best.cycles)),
                   std::isnan(planned.cost) ? "not" : options::rounded(1e3 * planned.cost)));
  if (planned.left_out > 0) {
    line("budget",
         fmt::format("{} s of CPU time: {} models and settings were not run to their end, "
                     "and a cheaper plan may be among them",
                     planned.budget, planned.left_out));
  }
  return text + "\nLeft out:\n" + chart::to_text(left_out(planned));
}

std::string plan_json(const Planned& planned) {
  const study::ReferenceSolution& reference = planned.reference;
  nlohmann::ordered_json json = {
      {"scene", planned.scene.file.string()},
      {"tolerance", planned.plan.tolerance},
      {"certificate", scenes::certificate(planned.plan)},
      {"until", planned.plan.until},
      {"error", planned.plan.error},
      {"error_at_frames", planned.best.error},
      {"method", planned.plan.method.name},
      {"settings", options::settings_json(planned.plan.method.settings)},
      {"particles", planned.plan.particles},
      {"bodies_as_links", planned.plan.links},
      {"neglected", names_of(planned.plan.neglected)},
      {"checked_by", checked_by(reference)},
      {"scored_metres", planned.scored},
      {"exact_known_to", planned.asked.per_metre * reference.self_error},
      {"cycles_per_second", planned.best.cycles},
      {"predicted_ms_per_second", milliseconds(planned.best.cycles)},
      {"measured_ms_per_second", program::number_or_null(1e3 * planned.cost)},
      {"over_budget", planned.left_out}};
  const ModelErrors& off = planned.models_off;
  if (reference.known > 1) {
    json["model_error"] = {{"twice_the_links", program::number_or_null(off.twice)},
                           {"four_times_the_links", program::number_or_null(off.four)}};
    if (off.rope) json["model_error"]["continuous_rope"] = *off.rope;
    if (off.span) json["model_error"]["massless_span"] = *off.span;
  }
  if (off.link) json["model_error"]["bodies_as_links"] = *off.link;
  for (const auto& [physics, error] : off.physics) {
    json["model_error"]["without"][std::string(name_of(physics))] = program::number_or_null(error);
  }
  if (const auto& blur = planned.blur) {
    json["exposures"] = {{"most", blur->most},
                         {"mean", blur->mean},
                         {"mean_as_written", blur->mean_as_written},
                         {"pixels_apart", blur->apart}};
  }
  if (reference.goes_on()) {
    const auto later = [](const study::Difference& difference) {
      return nlohmann::ordered_json{{"energy", difference.energy},
                                    {"stretch", difference.stretch},
                                    {"speeds", difference.speeds}};
    };
    json["later"] = {{"found", later(planned.best.later)}, {"allowed", later(reference.most)}};
  }
  if (planned.as_written.end == study::Trial::End::within) {
    json["as_written"] = {
        {"error", planned.as_written.error},
        {"predicted_ms_per_second", milliseconds(planned.as_written.cycles)},
        {"measured_ms_per_second", program::number_or_null(1e3 * planned.cost_as_written)}};
  }
  for (const auto& row : left_out(planned).rows) {
    json["left_out"].push_back({{"model", row[0]}, {"method", row[1]}, {"outcome", row[2]}});
  }
  return program::json_text(json) + "\n";
}

namespace {

std::string model_of(const scenes::Plan& plan) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [connector, particles] : plan.particles) {
    add(particles > 0 ? fmt::format("{}: {} particles", connector, particles)
                      : connector + ": a massless span");
  }
  for (const std::string& body : plan.links) add(body + " a link");
  for (const Physics one : plan.neglected) add(fmt::format("no {}", name_of(one)));
  if (plan.exposures > 0) add(fmt::format("{} exposures", plan.exposures));
  return text;
}

std::string found_of(const scenes::Plan& plan) {
  const std::string unit(scenes::read_length(plan.tolerance)->unit);
  std::string text = plan.until > 0 ? fmt::format("{} {} until {} s", options::rounded(plan.error),
                                                  unit, options::rounded(plan.until))
                                    : "not predictable";
  if (const auto& later = plan.afterwards) {
    text += fmt::format("; then energy {}%", options::rounded(100 * later->energy));
  }
  return text;
}

std::vector<std::string> row_of(const scenes::Scene& scene) {
  const std::string name = scene.file.stem().string();
  if (!scene.plan) {
    const char* const why = scene.strange_plan.empty() ? "has no plan" : "cannot be read";
    return {name, "-", "-", "-", why};
  }
  const scenes::Plan& plan = *scene.plan;
  const bool changed = plan.stamp != scenes::plan_stamp(scene.file);
  const bool moves_otherwise = plan.program != scenes::method_stamp(plan.method);
  return {name, plan.tolerance, model_of(plan), describe(plan.method),
          changed           ? "the scene changed since"
          : moves_otherwise ? "the method moves otherwise since"
                            : found_of(plan)};
}

}  // namespace

chart::Table plan_table(const std::vector<std::string>& scenes) {
  chart::Table table{{"scene", "asked", "model", "method", "found"}, {}};
  for (const std::string& scene : scenes) table.add(row_of(scenes::load_scene(scene, false)));
  return table;
}

program::Json plans_json(const std::vector<std::string>& files) {
  program::Json list = program::Json::array();
  for (const std::string& file : files) {
    const scenes::Scene scene = scenes::load_scene(file, false);
    program::Json one = {{"scene", file}, {"plan", nullptr}, {"strange", scene.strange_plan}};
    if (scene.plan) {
      const scenes::Plan& plan = *scene.plan;
      one["plan"] = {{"tolerance", plan.tolerance},
                     {"error", plan.error},
                     {"error_unit", scenes::read_length(plan.tolerance)->unit},
                     {"until_s", plan.until},
                     {"method", plan.method.name},
                     {"settings", options::settings_json(plan.method.settings)},
                     {"particles", plan.particles},
                     {"bodies_as_links", plan.links},
                     {"neglected", names_of(plan.neglected)},
                     {"exposures", plan.exposures},
                     {"scene_changed", plan.stamp != scenes::plan_stamp(scene.file)},
                     {"method_changed", plan.program != scenes::method_stamp(plan.method)}};
    }
    list.push_back(std::move(one));
  }
  return {{"scenes", std::move(list)}};
}

namespace {

constexpr double kCheckWork = 1.5e10;  // cycles of the independent check
constexpr double kFinely = 1e-2;  // of the tolerance: how finely models are solved to score them
constexpr double kFinerForClip = 0.9;
constexpr int kTimings = 5;
// Shares of the budget, each with what those before it left: until which part of it each may go on.
constexpr double kReference = 0.6, kModels = 0.7, kSearch = 0.9;
constexpr double kSolutions = 3;  // of the reference, side by side

/// CPU time for all the work of a plan.
class Budget {
 public:
  explicit Budget(double seconds) : seconds_(seconds) {}

  double seconds() const { return seconds_; }
  /// What is left (s) until that share of it is spent; at least nothing.
  double left(double share) const {
    return std::max(start_ + share * seconds_ - render::process_seconds(), 0.0);
  }

 private:
  double seconds_;
  double start_ = render::process_seconds();
};

/// CPU seconds per simulated second of stepping to the end, within `cap` (s); infinite where it
/// does not get there, not a number where there is no time for one run.
double cost_of(const study::PlanModel& model, const MethodChoice& candidate,
               const std::vector<double>& times, double cap) {
  std::vector<double> costs;
  const WorkLimit limit({.cpu_time = cap});
  try {
    for (int repeat = 0; repeat < kTimings; ++repeat) {
      check_stop();
      costs.push_back(study::time_run({model.world, times, model.timeline}, candidate) /
                      times.back());
    }
  } catch (const OverLimit&) {
    if (costs.empty()) return NAN;
  } catch (const Diverged&) {
    return INFINITY;
  }
  return study::spread(std::move(costs)).median;
}

/// The needs of the clip's blur, where the tolerance is of its pictures.
std::optional<Blur> blur_of(const scenes::Scene& scene, const study::ReferenceSolution& reference,
                            const Asked& asked) {
  if (!scene.stage || scene.stage->shutter == 0 || asked.unit != "px") return std::nullopt;
  // Of the frame from the time of each state to the next, the most that a point comes, px.
  std::vector<double> ways;
  for (std::size_t k = 1; k < reference.points.size(); ++k) {
    double most = 0;
    for (std::size_t i = 0; i < reference.points[k].size(); ++i) {
      const double way = asked.tolerance.distance(
          reference.points[k][i], reference.points[k - 1][i], reference.problem.times[k]);
      if (std::isfinite(way)) most = std::max(most, way);
    }
    ways.push_back(most);
  }
  constexpr int kSamples = 4;  // of a pixel, as render has them unless it is told otherwise
  const double apart = 2 * asked.tolerance.most;
  Blur blur;
  double fastest = 0, frames = 0;
  for (const scenes::ClipFrame& frame : scenes::clip_frames(scene)) {
    const auto k = static_cast<std::size_t>(frame.time * scene.fps);
    if (frame.card || k >= ways.size()) continue;
    const double way = ways[k] * scene.stage->shutter * frame.rate;
    const auto taken = [&](double gap, int most) {
      const std::vector<draw::Exposures> grades = draw::exposures(way, kSamples, most, gap);
      return way > 1 && !grades.empty() ? grades.back().count : 1;
    };
    fastest = std::max(fastest, ways[k] * scene.fps);
    blur.way = std::max(blur.way, way);
    blur.mean += taken(apart, scenes::kMostStates);
    blur.mean_as_written += taken(scene.stage->exposures_apart, scene.stage->exposures);
    blur.most = std::max(blur.most, taken(apart, scenes::kMostStates));
    ++frames;
  }
  if (frames == 0) return std::nullopt;
  blur.mean /= frames;
  blur.mean_as_written /= frames;
  blur.apart = blur.way / blur.most;
  if (blur.most > 1) blur.longest_step = std::max(apart, blur.apart) / fastest;
  return blur;
}

/// The most that the planned motion is off at all instants that the clip shows, as far as it is
/// predictable; none where these are the frames that the planner compares anyway.
std::optional<double> error_of_clip(const Planned& planned, double scored,
                                    const std::function<void(double)>& tick, double cap) {
  if (!planned.scene.stage) return std::nullopt;
  scenes::Scene clip = planned.scene;
  clip.method = planned.candidate();
  if (planned.blur) clip.stage->exposures = planned.blur->most;
  const std::vector<double> times = scenes::shown_times(clip, scenes::clip_frames(clip));
  const std::vector<double>& compared = planned.reference.problem.times;
  if (std::ranges::includes(compared, times)) return std::nullopt;
  const study::ReferenceSolution shown =
      study::at_times(planned.reference, scored, times, tick, cap);
  return study::distance_between(shown, planned.model().model.world, planned.model().model.timeline,
                                 planned.candidate(), planned.asked.tolerance.distance, cap);
}

/// The event of the timeline between two frames, in words.
std::string event_between(const Timeline& timeline, double from, double until) {
  const auto within = [&](double time) { return time >= from && time <= until; };
  for (const TimedPin& pin : timeline.pins) {
    if (within(pin.from)) return "a pin comes";
    if (within(pin.from + pin.over)) return "a pin arrives";
    if (within(pin.until)) return "a pin lets go";
  }
  for (const TimedCut& cut : timeline.cuts) {
    if (within(cut.time)) return "it is cut";
  }
  return {};
}

/// Solves every model finely, to see how good it is by itself, and gives candidates to those that
/// are good enough: what is beyond the tolerance when it is solved well must not be saved by errors
/// that cancel.
std::vector<study::PlanModel> score_models(std::vector<SceneModel>& scene_models,
                                           const study::ReferenceSolution& reference,
                                           const study::Tolerance& tolerance,
                                           const MethodChoice& finely, int fps, double longest_step,
                                           const Budget& budget, bool quiet) {
  std::vector<study::PlanModel> models;
  program::Progress progress("models", "models", scene_models.size(), quiet);
  constexpr std::size_t kBlock = 4;
  for (std::size_t k = 0; k < scene_models.size(); k += kBlock) {
    render::stop_if_interrupted();
    const double cap =
        budget.left(kModels) / static_cast<double>(std::min(kBlock, scene_models.size() - k));
    side_by_side(std::min(kBlock, scene_models.size() - k), [&](std::size_t i) {
      const study::Tolerance own = tolerance;  // a distance may remember what it was asked last
      SceneModel& one = scene_models[k + i];
      one.alone = cap > 0 ? study::attempt(one.model, finely, reference, own, INFINITY, cap)
                          : study::Trial{.end = study::Trial::End::cut};
    });
    progress.update(k);
  }
  for (SceneModel& one : scene_models) {
    if (one.alone.end == study::Trial::End::within) {
      one.model.candidates = all_candidates(one.model.world, fps, longest_step);
    }
    models.push_back(one.model);
  }
  return models;
}

study::Search search_all(const std::vector<study::PlanModel>& models,
                         const study::ReferenceSolution& reference,
                         const study::Tolerance& tolerance, const Budget& budget, bool quiet) {
  std::size_t total = 0;
  for (const study::PlanModel& model : models) total += model.candidates.size();
  program::Progress progress("planning", "runs", total, quiet);
  return search(
      models, reference, tolerance,
      [&](std::size_t done) {
        render::stop_if_interrupted();
        progress.update(done);
      },
      [&] { return budget.left(kSearch); });
}

scenes::Plan plan_of(const Planned& planned, const std::string& tolerance, std::uint64_t stamp) {
  const study::ReferenceSolution& reference = planned.reference;
  scenes::Plan plan{.tolerance = tolerance,
                    .error = planned.error,
                    .until = reference.known > 1 ? reference.horizon() : 0,
                    .stamp = stamp,
                    .method = planned.candidate(),
                    .particles = planned.model().particles,
                    .links = planned.model().links,
                    .neglected = planned.model().neglected};
  plan.program = scenes::method_stamp(plan.method);
  if (planned.blur) plan.exposures = planned.blur->most;
  if (reference.goes_on()) {
    const std::size_t last = reference.known > 0 ? reference.known - 1 : 0;
    if (reference.known > 1) {
      plan.end = event_between(reference.problem.timeline, reference.problem.times[last],
                               reference.problem.times[last + 1]);
    }
    using Work = scenes::Plan::Afterwards::Work;
    const study::Difference& later = planned.best.later;
    plan.afterwards = {reference.closed     ? Work::none
                       : reference.balanced ? Work::known
                                            : Work::unknown,
                       later.energy, later.stretch, later.speeds};
  }
  return plan;
}

}  // namespace

Planned make_plan(const scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                  Asked asked, const std::string& tolerance, std::uint64_t stamp, double seconds,
                  bool quiet) {
  const Budget budget(seconds);
  const double scored = asked.tolerance.most / asked.per_metre;
  const auto tick = [](program::Progress& progress) {
    return [&progress](double done) {
      render::stop_if_interrupted();
      progress.update(static_cast<std::size_t>(100 * done));
    };
  };
  const study::ReferenceSolution reference = [&] {
    program::Progress progress("solving the reference", "%", 100, quiet);
    double share = 0;
    try {
      return study::solve_reference(
          {few_copies(scene.world, scene.timeline), study::frame_times(scene.duration, scene.fps),
           scene.timeline},
          scored, kCheckWork,
          [&](double done) {
            share = done;
            tick(progress)(done);
          },
          budget.left(kReference) / kSolutions);
    } catch (const OverLimit&) {
      throw program::Misuse(fmt::format(
          "--budget {}: {:.0f} s of CPU time solve {:.2g}% of what there is to compare with, and "
          "nothing is planned; a larger budget, a coarser tolerance or a shorter scene (--set "
          "duration=...) help",
          seconds, kReference * seconds, 100 * share));
    }
  }();
  const std::optional<Blur> blur = blur_of(scene, reference, asked);
  asked.tolerance.most -= asked.per_metre * reference.self_error;

  const MethodChoice finely{"direct", {{"tolerance", scored * kFinely}}};
  std::vector<SceneModel> scene_models = models_of(
      scene, changes,
      negligible_physics(scene, reference, finely, asked.tolerance, budget.left(kModels)));
  const std::vector<study::PlanModel> models =
      score_models(scene_models, reference, asked.tolerance, finely, scene.fps,
                   blur ? blur->longest_step : INFINITY, budget, quiet);

  // Between frames a clip may show what is farther off than at any frame: then once more, finer.
  for (study::Tolerance within = asked.tolerance;;) {
    const study::Search search = search_all(models, reference, within, budget, quiet);
    std::size_t left_out = search.left_out;
    for (const SceneModel& model : scene_models) {
      if (model.alone.end == study::Trial::End::cut) ++left_out;
    }
    if (!search.best && left_out > 0) {
      throw program::Misuse(fmt::format(
          "--budget {}: {} models and settings were left out, and of the others none comes within "
          "{}; a larger budget, a coarser tolerance or a shorter scene (--set duration=...) help",
          seconds, left_out, tolerance));
    }
    if (!search.best) {
      const study::Trial* trial = nearest(search, scene_models);
      const SceneModel& model = trial ? scene_models[trial->model] : scene_models.front();
      throw program::Misuse(fmt::format(
          "--tolerance {}: no method at any of its settings comes so near; nearest: {}, {}: {}",
          tolerance, describe(model, scene),
          trial ? describe(models[trial->model].candidates[trial->candidate]) : "solved finely",
          outcome(trial ? *trial : model.alone, asked, reference)));
    }
    Planned planned{scene, asked, reference, scene_models, search, search.trials[*search.best]};
    planned.scored = scored;
    planned.blur = blur;
    planned.error = planned.best.error;
    planned.left_out = left_out;
    planned.budget = seconds;
    const auto rest = [&] { return budget.left(1); };
    if (reference.known > 1) try {
        program::Progress progress("proving the clip", "%", 100, quiet);
        planned.clip_error = error_of_clip(planned, scored, tick(progress), rest());
        planned.error = std::max(planned.error, planned.clip_error.value_or(0));
      } catch (const OverLimit&) {
        throw program::Misuse(fmt::format(
            "--budget {}: {} by {} is within {} at every frame, and no time was left to prove what "
            "the clip shows between them; a larger budget helps",
            seconds, describe(planned.model(), scene), describe(planned.candidate()), tolerance));
      }
    if (planned.error > asked.tolerance.most) {
      within.most *= kFinerForClip * asked.tolerance.most / planned.error;
      continue;
    }
    const study::PlanModel& written = models.front();
    planned.as_written =
        study::run_through(written, scene.method, reference, asked.tolerance.distance, rest());
    planned.models_off = model_errors(scene, changes, scene_models, reference, finely,
                                      asked.tolerance.distance, rest);
    const std::vector<double>& times = reference.problem.times;
    planned.cost = cost_of(planned.model().model, planned.candidate(), times, rest());
    planned.cost_as_written = planned.as_written.end == study::Trial::End::cut
                                  ? NAN
                                  : cost_of(written, scene.method, times, rest());
    planned.plan = plan_of(planned, tolerance, stamp);
    return planned;
  }
}

}  // namespace taut::planning
