#include "render/report/run_score.h"

#include <fmt/format.h>

#include <limits>

#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/json.h"
#include "render/study/accuracy_study.h"

namespace taut::cli {

std::vector<ErrorAt> errors_over_time(const Run& run, const Reference& reference, double length) {
  const Metric metric = share_of_length(length);
  std::vector<ErrorAt> errors;
  const std::size_t both = std::min(run.frames.size(), reference.frames.size());
  for (std::size_t k = 0; k < both; ++k) {
    errors.push_back({reference.frames[k].time,
                      frame_error(run.frames[k], reference.frames[k], metric.distance)});
  }
  return errors;
}

nlohmann::ordered_json run_score(const Scene& scene, double share) {
  if (scene.world.connectors.empty()) {
    throw Misuse(fmt::format("{}: has no connector to score", scene.file.string()));
  }
  if (!scene.timeline.cuts.empty()) {
    throw Misuse(fmt::format("{}: has cuts, which --score does not follow", scene.file.string()));
  }
  const double length = scored_length(scene);
  const Target target = scored_target(scene, share);
  const Run run = taut::run(target.problem, {scene.method.name, scene.method.settings},
                            std::numeric_limits<double>::infinity());
  const Reference& truth = target.reference;
  const bool diverged = run.end == Run::End::diverged;
  nlohmann::ordered_json json = {
      {"scene", scene.file.string()},
      {"method", scene.method.name},
      {"settings", settings_json(full_settings(scene.method))},
      {"horizon_s", truth.horizon},
      {"self_error", truth.self_error / length},
      {"rms_error", number_or_null(rms_error(run.frames, truth.frames, truth.horizon,
                                             share_of_length(length).distance))},
      {"cpu_ms_per_simulated_s", 1e3 * run.cpu / target.problem.duration()},
      {"diverged_at_s", diverged ? Json(run.failed_at) : Json(nullptr)},
      {"errors", nlohmann::ordered_json::array()}};
  for (const ErrorAt& at : errors_over_time(run, truth, length)) {
    json["errors"].push_back({{"t_s", at.time}, {"error", number_or_null(at.error)}});
  }
  return json;
}

}  // namespace taut::cli
