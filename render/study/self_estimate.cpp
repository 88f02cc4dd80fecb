#include "render/study/self_estimate.h"

#include <fmt/format.h>

#include <cmath>

#include "sim/evaluation/run.h"

namespace taut::studies {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity.
Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// Why there is no finite estimate, or empty.
std::string reason(const ErrorEstimate& estimate) {
  if (!estimate.none().empty()) return estimate.none();
  if (estimate.diverged().empty()) return {};
  return "the run beside it ended: " + estimate.diverged();
}

}  // namespace

const std::string_view kEstimateHelp =
    "The run estimates its own error: the same method runs beside it with other settings (direct: "
    "steps\n"
    "shorter by a fifth; others: tolerance times 4, or twice the step), and Richardson's\n"
    "extrapolation tells the error from the difference, as an RMS of all particles, in m. The "
    "motion\n"
    "is predictable until the estimate exceeds the tolerance asked for or, where the method has "
    "none\n"
    "in metres, a hundredth of the longest connector. --no-estimate saves its time.";

SelfEstimate::SelfEstimate(const scenes::Scene& scene, bool on) {
  if (on) estimate_.emplace(scene.world, scene.method.name, scene.method.settings, scene.timeline);
}

void SelfEstimate::follow(const Simulation& simulation) {
  if (!exists()) return;
  const double before = thread_seconds();
  estimate_->follow(simulation);
  seconds_ += thread_seconds() - before;
  until_ = simulation.world().time;
}

double SelfEstimate::error() const {
  return estimate_.value().error();
}

void SelfEstimate::add_to(nlohmann::ordered_json& record) const {
  if (!estimate_) return;
  const std::string why = reason(*estimate_);
  const auto until = estimate_->predictable_until();
  record["error_estimate_m"] = {{"largest", finite(estimate_->largest())},
                                {"final", finite(estimate_->error())}};
  record["error_estimate_reason"] = why.empty() ? Json(nullptr) : Json(why);
  record["predictable_until_s"] = until ? Json(*until) : Json(nullptr);
  record["predictable_until_is"] = fmt::format(
      "the first time at which the estimate exceeds {} m; null where it never does, or where there "
      "is no estimate",
      estimate_->limit());
  record["foretold_until_s"] = record["predictable_until_s"];  // its former name
  record["estimate_ms_per_second"] = until_ > 0 ? Json(1e3 * seconds_ / until_) : Json(nullptr);
}

std::string SelfEstimate::line() const {
  if (!estimate_) return {};
  const std::string why = reason(*estimate_);
  if (!estimate_->none().empty()) return "error estimate: none, as " + why + "\n";
  const auto until = estimate_->predictable_until();
  return fmt::format(
      "error estimate: {:.3g} m at most, {}{}\n", estimate_->largest(),
      until ? fmt::format("above {:.3g} m from {:.4g} s on", estimate_->limit(), *until)
            : fmt::format("never above {:.3g} m", estimate_->limit()),
      why.empty() ? "" : "; " + why);
}

}  // namespace taut::studies
