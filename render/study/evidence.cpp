#include "render/study/evidence.h"

#include <fmt/format.h>

#include <cmath>

#include "render/base/interrupt.h"
#include "render/program/command.h"
#include "render/study/study_target.h"

namespace taut::studies {
namespace {

/// The scene's rope let go from where it hangs between its first end and a point beside that, with
/// its middle particle held there: an intervention.
study::Problem with_pin(const options::StudyOptions& options) {
  const scenes::Scene scene = options::study_scene(options);
  const Connector& straight = scene.world.connectors.front();
  const Vec3 end = straight.position.front() + Vec3(0.6 * straight.length, 0, 0);
  const std::string start =
      fmt::format("{{ hanging_to = [{:.17g}, {:.17g}, {:.17g}] }}", end.x(), end.y(), end.z());
  study::Problem problem{
      options::study_scene(options, {{options::connector_key(scene, "start"), start}}).world,
      study::frame_times(scene.duration / 2, scene.fps)};
  problem.world = with_change(std::move(problem.world), [](World& world) {
    Connector& rope = world.connectors.front();
    Hold pin;
    pin.particle = rope.particles() / 2;
    pin.to.point = rope.position[pin.particle];
    rope.holds.push_back(pin);
    std::ranges::sort(rope.holds, {}, &Hold::particle);
  });
  return problem;
}

}  // namespace

Evidence gather_evidence(const options::StudyOptions& options, bool quiet) {
  Evidence evidence;
  evidence.bench = measure_bench(options, {kFew, kMany}, {}, quiet);
  const scenes::Scene scene = options::study_scene(options, kFew);
  evidence.length = scene.world.connectors.front().length;
  truth::TruthOptions truth;
  truth.scored_error = 1e-4 * evidence.length;
  truth.second_accuracy = 1e-7;
  const Target target = target_of(scene, scene.duration, truth);
  if (target.problem.times.size() < 2 || evidence.bench.blocks[0].paper.settings.empty()) {
    throw program::Misuse(fmt::format("{}: nothing is predictable", options.scene));
  }
  evidence.horizon = target.reference.horizon;
  const study::Metric metric = study::share_of_length(evidence.length);
  std::vector<std::vector<Snapshot>> all;
  for (const options::Contender& one : evidence.bench.contenders) {
    render::stop_if_interrupted();
    all.emplace_back();
    if (one.method->missing.empty()) {
      all.back() = taut::study::run(target.problem, one.candidate, 60).frames;
    }
    evidence.errors.push_back(
        study::rms_error(all.back(), target.reference.frames, evidence.horizon, metric.distance));
  }
  const auto& reference = all[evidence.at(PaperRole::dynamic_constraints)];
  for (const auto& frames : all) {
    double sum = 0;
    const std::size_t both = std::min(frames.size(), reference.size());
    for (std::size_t k = 0; k < both; ++k)
      sum += study::segment_difference(frames[k], reference[k]);
    evidence.differences.push_back(both ? sum / static_cast<double>(both) : NAN);
  }
  const study::Problem pinned = with_pin(options);
  const auto reference_pinned = quick_reference(pinned, 0.01 * evidence.length, 10);
  for (const options::Contender& one : evidence.bench.contenders) {
    render::stop_if_interrupted();
    evidence.pinned.push_back(NAN);
    if (!one.method->missing.empty() || !reference_pinned) continue;
    const study::Run result = taut::study::run(pinned, one.candidate, 60);
    evidence.pinned.back() = study::rms_error(result.frames, reference_pinned->frames,
                                              reference_pinned->horizon, metric.distance);
  }
  const std::string proposed(find_method(PaperRole::proposed)->name);
  std::vector<double> with, without;
  for (int i = 0; i < 15; ++i) {
    render::stop_if_interrupted();
    with.push_back(study::time_run(target.problem, {proposed, {}}));
    without.push_back(study::time_run(target.problem, {proposed, {{"h", 0.0}}}));
  }
  evidence.always = study::spread(without).median / study::spread(with).median;
  return evidence;
}

}  // namespace taut::studies
