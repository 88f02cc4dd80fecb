#include "render/report/run_score.h"

#include <fmt/format.h>

#include <limits>

#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/json.h"
#include "render/study/accuracy_study.h"

namespace taut::report {

std::vector<ErrorAt> errors_over_time(const study::Run& run, const truth::Reference& reference,
                                      double length) {
  const study::Metric metric = study::share_of_length(length);
  std::vector<ErrorAt> errors;
  const std::size_t both = std::min(run.frames.size(), reference.frames.size());
  for (std::size_t k = 0; k < both; ++k) {
    errors.push_back({reference.frames[k].time,
                      study::frame_error(run.frames[k], reference.frames[k], metric.distance)});
  }
  return errors;
}

nlohmann::ordered_json run_score(const scenes::Scene& scene, double share) {
  if (scene.world.connectors.empty()) {
    throw program::Misuse(fmt::format("{}: has no connector to score", scene.file.string()));
  }
  if (!scene.timeline.cuts.empty()) {
    throw program::Misuse(
        fmt::format("{}: has cuts, which --score does not follow", scene.file.string()));
  }
  const double length = studies::scored_length(scene);
  const studies::Target target = studies::scored_target(scene, share);
  const study::Run run =
      study::run(target.problem, scene.method, std::numeric_limits<double>::infinity());
  const truth::Reference& truth = target.reference;
  const bool diverged = run.end == study::Run::End::diverged;
  nlohmann::ordered_json json = {
      {"scene", scene.file.string()},
      {"method", scene.method.name},
      {"settings", options::settings_json(with_defaults(scene.method))},
      {"horizon_s", truth.horizon},
      {"self_error", truth.self_error / length},
      {"rms_error",
       program::number_or_null(study::rms_error(run.frames, truth.frames, truth.horizon,
                                                study::share_of_length(length).distance))},
      {"cpu_ms_per_simulated_s", 1e3 * run.cpu / target.problem.duration()},
      {"diverged_at_s", diverged ? program::Json(run.failed_at) : program::Json(nullptr)},
      {"errors", nlohmann::ordered_json::array()}};
  for (const ErrorAt& at : errors_over_time(run, truth, length)) {
    json["errors"].push_back({{"t_s", at.time}, {"error", program::number_or_null(at.error)}});
  }
  return json;
}

}  // namespace taut::report
