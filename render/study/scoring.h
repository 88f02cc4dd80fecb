// The runs behind `taut chart`: what they are scored against, and the scores of many settings
// within a given time; and the estimate of one run's own error.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/program/part.h"
#include "render/study/accuracy_page.h"
#include "render/study/study_target.h"
#include "scenes/scene/scene.h"
#include "sim/run/error_estimate.h"

namespace taut::studies {

/// The key of a candidate's row in a journal.
std::string score_key(const MethodChoice& candidate);

/// The candidates of all contenders, in the order in which they are scored.
std::vector<MethodChoice> all_candidates(const AccuracyStudy& study, bool quick);

/// The CPU time (s) that one run may take where scoring may take `seconds`.
double cap_of_a_run(const AccuracyStudy& study, double seconds);

/// A candidate's row as a journal has it, scored within a CPU time of `cap` (s) and timed a few
/// times, less often where it takes more than `slow` (s).
std::vector<std::string> scored_and_timed(const Target& target,
                                          const std::vector<study::Metric>& metrics,
                                          const MethodChoice& candidate, double cap, double slow);

/// The row that a journal has so.
study::AccuracyRow row_from(const MethodChoice& candidate, const std::vector<std::string>& cells);

/// Scores every candidate of every contender, cheap ones first, within equal shares of `seconds`.
/// Rows that the journal holds are taken from it, others added; null: there is none.
void score_all(AccuracyStudy& study, const Target& target,
               const std::vector<study::Metric>& metrics, double seconds, bool quick,
               program::Journal* journal, bool quiet);

/// Times the fronts again and again, and once they are known well all others a few times, in turn,
/// until `seconds` are over; those that take more than `slow` seconds less often, for they would
/// eat the time of all others.
void time_all(AccuracyStudy& study, const Target& target, std::size_t metrics, double seconds,
              double slow);

// The estimate of a run's own error, for every command that makes one run of a scene.

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

// Shares of a study's budget: for finding errors, and for repeating timings; and the share from
// which on a run is timed less often.
inline constexpr double kScoring = 0.6, kTiming = 0.4, kSlow = 0.002;

/// The length (m) of the scene's first connector, by which errors are measured. Throws Misuse where
/// it has none.
double scored_length(const scenes::Scene& scene);

/// The least error, as a share of the length, that a study of so many settings scores.
double least_share(bool quick);

/// The truth of the scene for errors from `share` of the length up. Throws Misuse where nothing is
/// predictable.
Target scored_target(const scenes::Scene& scene, double share);

/// Shares of the length and, where the scene has a camera, pixels.
std::vector<study::Metric> accuracy_metrics(const scenes::Scene& scene);

/// The study that the options ask for, without rows.
AccuracyStudy accuracy_study(const options::StudyOptions& options, const scenes::Scene& scene);

/// Scores and times every candidate within `budget` (s). Rows that the journal holds are taken from
/// it; null: there is none.
void measure(AccuracyStudy& study, const Target& target, const std::vector<study::Metric>& metrics,
             double budget, bool quick, program::Journal* journal, bool quiet);

/// Takes all rows from the merged journal of parts.
void merge_rows(AccuracyStudy& study, const std::vector<study::Metric>& metrics, bool quick,
                program::Journal& journal);

}  // namespace taut::studies
