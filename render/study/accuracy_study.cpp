#include "render/study/accuracy_study.h"

#include "render/program/command.h"
#include "render/study/scoring.h"

namespace taut::studies {
namespace {

constexpr double kTargets[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};  // shares of the length

void find_unsteadiness(AccuracyStudy& study) {
  std::vector<study::AccuracyRow> rows;
  for (const AccuracyBlock& block : study.blocks) {
    rows.insert(rows.end(), block.rows.begin(), block.rows.end());
  }
  study.unsteadiness = study::unsteadiness(rows);
}

}  // namespace

double scored_length(const scenes::Scene& scene) {
  const double length = scene.world.connectors.front().length;
  if (!(length > 0)) throw program::Misuse("a joint has no length to measure errors by");
  return length;
}

double least_share(bool quick) {
  return quick ? 1e-4 : 1e-6;
}

Target scored_target(const scenes::Scene& scene, double share) {
  truth::TruthOptions truth;
  truth.scored_error = scored_length(scene) * share;
  if (share >= least_share(true)) truth.second_accuracy = 1e-7;
  return predictable_target(scene, truth);
}

std::vector<study::Metric> accuracy_metrics(const scenes::Scene& scene) {
  std::vector<study::Metric> metrics{study::share_of_length(scored_length(scene))};
  if (const auto pixels = pixels_of(scene)) metrics.push_back(*pixels);
  return metrics;
}

AccuracyStudy accuracy_study(const options::StudyOptions& options, const scenes::Scene& scene) {
  AccuracyStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  study.set = options.inputs.set;
  study.share = least_share(options.quick);
  study.particles = scene.world.connectors.front().particles();
  study.targets.assign(std::begin(kTargets), std::end(kTargets));
  study.in_pixels = pixels_of(scene).has_value();
  for (const options::Contender& contender : options::contenders_on(options, scene.world)) {
    study.blocks.push_back({contender, {}});
  }
  return study;
}

void measure(AccuracyStudy& study, const Target& target, const std::vector<study::Metric>& metrics,
             double budget, bool quick, program::Journal* journal, bool quiet) {
  score_all(study, target, metrics, kScoring * budget, quick, journal, quiet);
  time_all(study, target, metrics.size(), kTiming * budget, kSlow * budget);
  find_unsteadiness(study);
}

void merge_rows(AccuracyStudy& study, const std::vector<study::Metric>& metrics, bool quick,
                program::Journal& journal) {
  constexpr double kNoTime = 1;  // s; nothing is run
  score_all(study, {}, metrics, kNoTime, quick, &journal, true);
  find_unsteadiness(study);
}

}  // namespace taut::studies
