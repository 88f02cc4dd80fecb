#include "render/study/model_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/base/interrupt.h"
#include "sim/evaluation/run.h"

namespace taut::studies {
namespace {

constexpr std::size_t kCoarsest = 5;          // links
constexpr std::size_t kDoublings = 5;         // to 160 links
constexpr double kKnown = 1e-3;               // share of the length: the rope is known
constexpr double kTolerance = 1e-6;           // m, of the direct method: far below model errors
constexpr double kSpanStep = 1.0 / 60 / 256;  // s
constexpr double kSpanPasses = 16;

/// A run: a chain of so many links, by a method.
struct ModelRun {
  std::size_t links = 0;
  MethodChoice candidate;
};

ModelRun exact_run(std::size_t doublings) {
  return {kCoarsest << doublings, {"direct", {{"tolerance", kTolerance}}}};
}

ModelRun massless_run(std::size_t doublings) {
  return {kCoarsest << doublings, {"impulse", {{"step", kSpanStep}, {"passes", kSpanPasses}}}};
}

std::vector<ModelRun> model_runs() {
  std::vector<ModelRun> runs;
  for (std::size_t d = 0; d <= kDoublings + 1; ++d) runs.push_back(exact_run(d));
  for (std::size_t d = 0; d <= kDoublings; ++d) runs.push_back(massless_run(d));
  return runs;
}

std::string key_of(const ModelRun& run) {
  return fmt::format("model {} {}", run.links, run.candidate.name);
}

/// Where the particles are that a chain of kCoarsest links has too, frame by frame.
using Frames = std::vector<std::vector<Vec3>>;

struct Motion {
  Frames frames;
  double cost = 0;  // CPU s per simulated second
};

Motion motion_of(const options::StudyOptions& options, double duration, const ModelRun& chosen) {
  render::stop_if_interrupted();
  const std::size_t links = chosen.links;
  const scenes::Scene scene = options::study_scene(options, links + 1);
  const study::Problem problem{scene.world, study::frame_times(duration, scene.fps),
                               scene.timeline};
  const study::Run result = study::run(problem, chosen.candidate, 60);
  Motion motion;
  for (const Snapshot& frame : result.frames) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i <= kCoarsest; ++i) {
      points.push_back(frame.connectors.front()[i * links / kCoarsest]);
    }
    motion.frames.push_back(std::move(points));
  }
  motion.cost = result.cpu / problem.duration();
  return motion;
}

std::vector<std::string> cells_of(const Motion& motion) {
  std::vector<std::string> cells{program::exact(motion.cost)};
  for (const auto& points : motion.frames) {
    for (const Vec3& point : points) {
      for (const double x : point) cells.push_back(program::exact(x));
    }
  }
  return cells;
}

/// The motion as it was written down or, where it was not, as it is.
Motion known_motion(const options::StudyOptions& options, double duration, const ModelRun& chosen,
                    program::Journal& journal) {
  const std::string key = key_of(chosen);
  Motion motion;
  if (const auto* cells = journal.find(key)) {
    motion.cost = program::number_in(cells->front());
    for (std::size_t i = 1; i + 3 * (kCoarsest + 1) <= cells->size(); i += 3 * (kCoarsest + 1)) {
      std::vector<Vec3> points;
      for (std::size_t p = 0; p <= kCoarsest; ++p) {
        points.emplace_back(program::number_in((*cells)[i + 3 * p]),
                            program::number_in((*cells)[i + 3 * p + 1]),
                            program::number_in((*cells)[i + 3 * p + 2]));
      }
      motion.frames.push_back(std::move(points));
    }
    return motion;
  }
  motion = motion_of(options, duration, chosen);
  journal.add(key, cells_of(motion));
  return motion;
}

/// Where errors that halve from `coarse` to `fine` lead to.
Frames limit_of(const Frames& coarse, const Frames& fine) {
  Frames limit = fine;
  limit.resize(std::min(coarse.size(), fine.size()));
  for (std::size_t k = 0; k < limit.size(); ++k) {
    for (std::size_t i = 0; i < limit[k].size(); ++i) limit[k][i] += fine[k][i] - coarse[k][i];
  }
  return limit;
}

double rms(const Frames& a, const Frames& b, std::size_t frames) {
  if (a.size() < frames || b.size() < frames) return INFINITY;
  double squares = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    for (std::size_t i = 0; i < a[k].size(); ++i) squares += (a[k][i] - b[k][i]).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, frames * a[0].size())));
}

}  // namespace

std::vector<std::string> model_keys() {
  std::vector<std::string> keys;
  for (const ModelRun& run : model_runs()) keys.push_back(key_of(run));
  return keys;
}

std::vector<std::string> model_row(const options::StudyOptions& options, double duration,
                                   std::size_t index) {
  return cells_of(motion_of(options, duration, model_runs().at(index)));
}

ModelStudy model_study(const options::StudyOptions& options, double duration,
                       program::Journal& journal) {
  const scenes::Scene scene = options::study_scene(options);
  const double length = scene.world.connectors.front().length;
  std::vector<Motion> motions;  // of 5, 10, ... 320 links
  for (std::size_t d = 0; d <= kDoublings + 1; ++d) {
    motions.push_back(known_motion(options, duration, exact_run(d), journal));
  }
  const Frames rope = limit_of(motions[kDoublings].frames, motions[kDoublings + 1].frames);
  const Frames before = limit_of(motions[kDoublings - 1].frames, motions[kDoublings].frames);
  std::size_t known = 0;
  while (known < std::min(rope.size(), before.size()) &&
         rms(rope, before, known + 1) <= kKnown * length) {
    ++known;
  }
  ModelStudy study;
  if (known == 0) return study;
  study.until = static_cast<double>(known - 1) / scene.fps;
  study.uncertainty = rms(rope, before, known) / length;
  for (std::size_t d = 0; d <= kDoublings; ++d) {
    const Motion span = known_motion(options, duration, massless_run(d), journal);
    study.rows.push_back({(kCoarsest << d) + 1, rms(motions[d].frames, rope, known) / length,
                          rms(span.frames, rope, known) / length, motions[d].cost});
  }
  return study;
}

chart::Table model_table(const ModelStudy& study) {
  chart::Table table{{"particles", "rigid links: error (share of length)",
                      "massless span: error (share of length)", "direct: ms per simulated second"},
                     {}};
  for (const ModelRow& row : study.rows) {
    table.add({std::to_string(row.particles), options::rounded(row.links),
               options::rounded(row.span), options::rounded(1e3 * row.cost)});
  }
  return table;
}

chart::Chart model_chart(const ModelStudy& study, const std::string& title) {
  chart::Chart chart;
  chart.width = 1000;
  chart.height = 620;
  chart.title = "The continuous rope is not known long enough to score chains by";
  chart::Panel panel;
  panel.x = {"particles n", true};
  panel.y = {"RMS position error (share of the length)", true};
  chart::Series links{"rigid links", {0x0072b2, 0, 1}, true, true, false, {}};
  chart::Series span{
      "massless span (the model of impulse)", {0xd55e00, 1, 0}, true, true, false, {}};
  for (const ModelRow& row : study.rows) {
    const auto n = static_cast<double>(row.particles);
    links.points.push_back({n, row.links});
    span.points.push_back({n, row.span});
    panel.x.tics.emplace_back(n, std::to_string(row.particles));
  }
  if (!study.rows.empty()) {
    const ModelRow &first = study.rows.front(), &last = study.rows.back();
    const double order = std::log2(study.rows[study.rows.size() - 2].links / last.links);
    chart.title = fmt::format(
        "{} particles miss the continuous rope by {}% of its length, {} particles by {}%, a "
        "massless span by {}%",
        first.particles, options::rounded(100 * first.links), last.particles,
        options::rounded(100 * last.links), options::rounded(100 * last.span));
    chart.subtitle = fmt::format(
        "{}: the model's error in the first {} s, which no method removes. Of n particles it falls "
        "as 1/n^{:.2g} in the end. The continuous rope is extrapolated from 161 and 321 particles "
        "and known to {}% of the length.",
        title, options::rounded(study.until), order, options::rounded(100 * study.uncertainty));
    panel.rules.push_back({study.uncertainty, false, "how well the continuous rope is known"});
  }
  panel.series = {std::move(links), std::move(span)};
  chart.panels = {std::move(panel)};
  return chart;
}

}  // namespace taut::studies
