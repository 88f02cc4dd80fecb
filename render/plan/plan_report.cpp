#include "render/plan/plan_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "render/chart/table.h"
#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "render/program/json.h"
#include "sim/motion/printable.h"
#include "sim/run/bodies_as_links.h"
#include "sim/topology/span.h"

namespace taut::planning {
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

}  // namespace taut::planning
