// The estimate of a run's own error, for every command that makes one run of a scene.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "scenes/scene/scene.h"
#include "sim/run/error_estimate.h"

namespace taut::studies {

/// The text of --help on the estimate.
extern const std::string_view kEstimateHelp;

/// An ErrorEstimate of a scene's simulation that keeps the time which it takes; or none, where it
/// is switched off.
class SelfEstimate {
 public:
  SelfEstimate(const scenes::Scene& scene, bool on);

  /// Goes to where the simulation is now.
  void follow(const Simulation& simulation);

  /// True where it is switched on and the method has one.
  bool exists() const { return estimate_ && estimate_->none().empty(); }
  /// At the last frame, m; infinite once the run beside it diverged. It has to exist.
  double error() const;

  /// Adds error_estimate_m, predictable_until_s, estimate_ms_per_second and what they mean to a
  /// record of the run; nothing where it is switched off.
  void add_to(nlohmann::ordered_json& record) const;
  /// The same as one line, empty where it is switched off.
  std::string line() const;

 private:
  std::optional<ErrorEstimate> estimate_;
  double seconds_ = 0;  // of CPU time
  double until_ = 0;    // s, where the simulation was last
};

}  // namespace taut::studies
