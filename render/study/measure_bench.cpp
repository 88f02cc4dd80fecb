#include <fmt/format.h>

#include <algorithm>

#include "render/base/interrupt.h"
#include "render/program/note.h"
#include "render/program/program.h"
#include "render/program/progress.h"
#include "render/study/bench_results.h"
#include "render/study/study_target.h"

namespace taut::studies {
namespace {

constexpr int kFrames = 100;

study::Problem frames_of(const scenes::Scene& scene) {
  study::Problem problem{scene.world, {}, scene.timeline};
  for (int k = 1; k <= kFrames; ++k) problem.times.push_back(static_cast<double>(k) / scene.fps);
  return problem;
}

/// The paper's ratio at one number of particles, over the first frames of the scene.
study::PaperRatio measure_ratio(const options::StudyOptions& options,
                                const std::vector<options::Contender>& contenders,
                                const scenes::Scene& scene, double seconds) {
  for (const PaperRole role : {PaperRole::proposed, PaperRole::particle_system}) {
    const bool timed = options::place_of(contenders, role) < contenders.size();
    if (!timed || !follows(*find_method(role), scene.world)) return {};
  }
  truth::TruthOptions truth;  // errors of a hundredth of the length are asked for, and not less
  truth.scored_error = 0.01 * scene.world.connectors.front().length;
  truth.local_error = 1e-9;
  truth.second_accuracy = 1e-5;
  const Target target = target_of(scene, static_cast<double>(kFrames) / scene.fps, truth);
  std::vector<study::Entrant> entrants;
  for (const options::Contender& one : contenders) {
    entrants.push_back({one.label, one.method, options::candidates_of(one, options.quick)});
  }
  return study::paper_ratio(target.problem, target.reference, 1.0 / scene.fps, entrants, seconds,
                            render::stop_if_interrupted);
}

BenchBlock measure(const options::StudyOptions& options,
                   const std::vector<options::Contender>& contenders, std::size_t particles,
                   double seconds) {
  const scenes::Scene scene = options::study_scene(options, particles);
  std::vector<MethodChoice> candidates;
  for (const options::Contender& one : contenders) {
    if (one.method->missing.empty()) candidates.push_back(one.candidate);
  }
  study::BenchOptions limits;
  limits.repeats = options.quick ? 5 : 25;
  limits.seconds = seconds / 2 / static_cast<double>(std::max<std::size_t>(1, candidates.size()));
  limits.pause = render::stop_if_interrupted;
  std::vector<study::BenchRow> measured = study::bench(frames_of(scene), candidates, limits);
  BenchBlock block;
  block.particles = particles;
  std::size_t next = 0;
  for (const options::Contender& one : contenders) {
    if (one.method->missing.empty()) {
      block.rows.push_back(std::move(measured[next++]));
    } else {
      study::BenchRow row;
      row.candidate = one.candidate;
      row.failure = one.method->missing;
      block.rows.push_back(std::move(row));
    }
  }
  block.paper = measure_ratio(options, contenders, scene, seconds / 2);
  return block;
}

}  // namespace

BenchResults measure_bench(const options::StudyOptions& options,
                           const std::vector<std::size_t>& particles, const std::string& asked,
                           bool quiet) {
  const std::vector<options::Contender> contenders = options::chosen_contenders(options);
  const std::size_t springs = options::place_of(contenders, PaperRole::particle_system);
  const std::string against =
      !asked.empty() ? asked : contenders[springs < contenders.size() ? springs : 0].label;
  BenchResults results{options::study_scene(options), contenders, against, {}};
  if (std::ranges::find(results.contenders, against, &options::Contender::label) ==
      results.contenders.end()) {
    throw program::Misuse(fmt::format("--against: {} is not among the methods timed", against));
  }
  const double seconds = options.budget / static_cast<double>(particles.size());
  program::Progress progress("timing", "numbers of particles", particles.size(), true);
  for (const std::size_t n : particles) {
    if (!quiet) program::note("timing {} particles\n", n);
    results.blocks.push_back(measure(options, results.contenders, n, seconds));
    progress.update(results.blocks.size());
  }
  return results;
}

}  // namespace taut::studies
