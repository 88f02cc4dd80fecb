#include "render/study/bench_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/base/interrupt.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/program/program.h"
#include "render/study/study_target.h"

namespace taut::studies {
namespace {

bool timed(const study::BenchRow& row) {
  return row.failure.empty() && row.repeats > 0;
}

/// How many times as fast as the contender that others are compared with; zero where one of the two
/// has no timing.
double ratio(const BenchResults& results, const BenchBlock& block, std::size_t row) {
  const auto other =
      std::ranges::find(results.contenders, results.against, &options::Contender::label);
  if (other == results.contenders.end()) return 0;
  const study::BenchRow& against =
      block.rows[static_cast<std::size_t>(other - results.contenders.begin())];
  if (!timed(against) || !timed(block.rows[row])) return 0;
  return against.mean.median / block.rows[row].mean.median;
}

/// The block of the scene's own number of particles, or the first.
const BenchBlock& own_block(const BenchResults& results) {
  for (const BenchBlock& block : results.blocks) {
    if (block.particles == results.scene.world.connectors.front().particles()) return block;
  }
  return results.blocks.front();
}

std::string finding(const BenchResults& results) {
  const BenchBlock& block = own_block(results);
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < block.rows.size(); ++c) {
    if (timed(block.rows[c])) order.push_back(c);
  }
  if (order.empty()) return "No method could be timed";
  std::ranges::sort(order, {}, [&](std::size_t c) { return block.rows[c].mean.median; });
  const std::size_t fastest = order.front(), slowest = order.back();
  const double factor = ratio(results, block, fastest);
  std::string line = fmt::format("At {} particles {} is fastest with {} µs a frame",
                                 block.particles, results.contenders[fastest].label,
                                 options::rounded(1e6 * block.rows[fastest].mean.median));
  if (factor > 0 && results.contenders[fastest].label != results.against) {
    line += fmt::format(", {} times as fast as {}", options::rounded(factor), results.against);
  }
  return line + fmt::format("; {} is slowest with {} µs", results.contenders[slowest].label,
                            options::rounded(1e6 * block.rows[slowest].mean.median));
}

chart::Panel growth_panel(const BenchResults& results) {
  chart::Panel panel;
  panel.title = "mean of a frame";
  panel.x = {"particles", true};
  panel.y = {"CPU time per frame (µs)", true};
  for (const BenchBlock& block : results.blocks) {
    panel.x.tics.emplace_back(static_cast<double>(block.particles),
                              std::to_string(block.particles));
  }
  for (std::size_t c = 0; c < results.contenders.size(); ++c) {
    chart::Series means{options::legend_name(results.contenders[c]),
                        results.contenders[c].style,
                        true,
                        true,
                        false,
                        {}};
    for (const BenchBlock& block : results.blocks) {
      const study::Spread& mean = block.rows[c].mean;
      if (!timed(block.rows[c])) continue;
      means.points.push_back({static_cast<double>(block.particles), 1e6 * mean.median, chart::kAuto,
                              chart::kAuto, 1e6 * mean.low, 1e6 * mean.high});
    }
    panel.series.push_back(std::move(means));
  }
  panel.rules.push_back({1e6 / results.scene.fps, false, "real time"});
  return panel;
}

chart::Panel frames_panel(const BenchResults& results) {
  const BenchBlock& block = own_block(results);
  chart::Panel panel;
  panel.title = fmt::format("each frame, {} particles", block.particles);
  panel.x = {fmt::format("frame (1/{} s)", results.scene.fps)};
  panel.y = {"CPU time per frame (µs)", true};
  for (std::size_t c = 0; c < results.contenders.size(); ++c) {
    chart::Series line{options::legend_name(results.contenders[c]),
                       results.contenders[c].style,
                       true,
                       false,
                       false,
                       {}};
    const auto& frames = block.rows[c].frames;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (frames[k].median > 0) {
        line.points.push_back({static_cast<double>(k + 1), 1e6 * frames[k].median});
      }
    }
    panel.series.push_back(std::move(line));
  }
  panel.rules.push_back({1e6 / results.scene.fps, false, "real time"});
  return panel;
}

/// The particle system's cost over the paper's method's: as both come, and at equal error.
chart::Panel ratio_panel(const BenchResults& results) {
  chart::Panel panel;
  panel.title = "cost of springs over cost of impulse";
  panel.x = {"particles", true};
  panel.y = {"ratio of CPU times", true};
  panel.rules.push_back(
      {study::kPaperRatio, false, fmt::format("the paper: {}", study::kPaperRatio)});
  panel.rules.push_back({1, false, "equal"});
  chart::Series plain{
      "ratio at default settings, errors not equal", {0x444444, 0, 6}, true, true, false, {}};
  chart::Series coarse{"ratio at the error of impulse with one step a frame",
                       {0xd55e00, 2, 4, true},
                       true,
                       true,
                       false,
                       {}};
  chart::Series fine{"ratio at the least error that impulse reaches",
                     {0x8c2981, 1, 7, true},
                     true,
                     true,
                     false,
                     {}};
  for (const BenchBlock& block : results.blocks) {
    const auto n = static_cast<double>(block.particles);
    panel.x.tics.emplace_back(n, std::to_string(block.particles));
    const auto cost = [&](PaperRole role) {
      const std::size_t c = options::place_of(results.contenders, role);
      return c < block.rows.size() && timed(block.rows[c]) ? block.rows[c].mean.median : 0;
    };
    const double impulse = cost(PaperRole::proposed), springs = cost(PaperRole::particle_system);
    if (impulse > 0 && springs > 0) plain.points.push_back({n, springs / impulse});
    std::vector<study::EqualError> reached;
    for (const study::EqualError& one : block.paper.equal) {
      if (one.method == find_method(PaperRole::particle_system)->name && one.cost > 0)
        reached.push_back(one);
    }
    if (reached.empty()) continue;
    const auto [least, most] = std::ranges::minmax(reached, {}, &study::EqualError::error);
    coarse.points.push_back({n, most.cost / most.impulse_cost});
    fine.points.push_back({n, least.cost / least.impulse_cost});
  }
  panel.series = {std::move(plain), std::move(coarse), std::move(fine)};
  return panel;
}

program::Json json_of(const BenchResults& results, const BenchBlock& block, std::size_t index) {
  const study::BenchRow& row = block.rows[index];
  const auto micro = [&](double seconds) {
    return timed(row) ? program::Json(1e6 * seconds) : program::Json();
  };
  const double factor = ratio(results, block, index);
  return {{"particles", block.particles},
          {"method", results.contenders[index].label},
          {"settings", options::settings_json(row.candidate.settings)},
          {"steps_per_frame", timed(row) ? program::Json(row.steps) : program::Json()},
          {"cpu_us_per_frame", micro(row.mean.median)},
          {"low_quartile_us", micro(row.mean.low)},
          {"high_quartile_us", micro(row.mean.high)},
          {"times_as_fast", factor > 0 ? program::Json(factor) : program::Json()},
          {"repeats", row.repeats},
          {"failure", row.failure.empty() ? program::Json() : program::Json(row.failure)}};
}

program::Json json_of(const study::PaperSetting& s) {
  return {{"particles", s.particles},
          {"impulse_steps_per_frame", s.impulse_steps},
          {"impulse_rms_error", program::number_or_null(s.impulse_error)},
          {"springs_steps_per_frame", s.substeps},
          {"springs_stiffness_n_per_m", s.stiffness},
          {"springs_rms_error", program::number_or_null(s.error)},
          {"springs_stretch_max", program::number_or_null(s.stretch)},
          {"cost_ratio", program::number_or_null(s.ratio)}};
}

program::Json json_of(const study::EqualError& e) {
  const bool known = e.cost > 0;
  return {
      {"particles", e.particles},
      {"rms_error", program::number_or_null(e.error)},
      {"method", e.method},
      {"impulse_cpu_ms_per_simulated_s", 1e3 * e.impulse_cost},
      {"cpu_ms_per_simulated_s", known ? program::Json(1e3 * e.cost) : program::Json()},
      {"cost_ratio", known ? program::number_or_null(e.cost / e.impulse_cost) : program::Json()}};
}

}  // namespace

chart::Table settings_table(const BenchResults& results) {
  chart::Table table{
      {"particles", "impulse: steps per frame", "impulse: error (share of length)",
       "springs: steps per frame", "springs: stiffness (N/m)", "springs: error (share of length)",
       "springs: largest stretch", "springs / impulse"},
      {}};
  for (const BenchBlock& block : results.blocks) {
    for (const study::PaperSetting& s : block.paper.settings) {
      table.add({std::to_string(s.particles), options::rounded(s.impulse_steps),
                 options::rounded(s.impulse_error), options::rounded(s.substeps),
                 options::rounded(s.stiffness), options::rounded(s.error),
                 options::rounded(s.stretch), options::rounded(s.ratio)});
    }
  }
  return table;
}

chart::Table equal_error_table(const BenchResults& results) {
  chart::Table table{{"particles", "error (share of length)", "method", "impulse: ms per second",
                      "method: ms per second", "method / impulse"},
                     {}};
  for (const BenchBlock& block : results.blocks) {
    for (const study::EqualError& e : block.paper.equal) {
      const bool known = e.cost > 0;
      table.add({std::to_string(e.particles), options::rounded(e.error), e.method,
                 options::rounded(1e3 * e.impulse_cost),
                 known ? options::rounded(1e3 * e.cost) : "-",
                 known ? options::rounded(e.cost / e.impulse_cost) : "-"});
    }
  }
  return table;
}

chart::Table bench_table(const BenchResults& results) {
  chart::Table table{
      {"particles", "method", "settings", "steps per frame", "µs per frame", "low quartile",
       "high quartile", "times as fast as " + results.against, "repeats", "remark"},
      {}};
  for (const BenchBlock& block : results.blocks) {
    for (std::size_t c = 0; c < results.contenders.size(); ++c) {
      const study::BenchRow& row = block.rows[c];
      const auto micro = [&](double seconds) {
        return timed(row) ? options::rounded(1e6 * seconds) : "-";
      };
      const double factor = ratio(results, block, c);
      table.add({std::to_string(block.particles), results.contenders[c].label,
                 describe(row.candidate.settings), timed(row) ? options::rounded(row.steps) : "-",
                 micro(row.mean.median), micro(row.mean.low), micro(row.mean.high),
                 factor > 0 ? options::rounded(factor) : "-", std::to_string(row.repeats),
                 row.failure});
    }
  }
  return table;
}

chart::Table bench_frames_table(const BenchResults& results) {
  chart::Table table{
      {"particles", "method", "frame", "median (s)", "low quartile (s)", "high quartile (s)"}, {}};
  for (const BenchBlock& block : results.blocks) {
    for (std::size_t c = 0; c < results.contenders.size(); ++c) {
      const auto& frames = block.rows[c].frames;
      for (std::size_t k = 0; k < frames.size(); ++k) {
        table.add({std::to_string(block.particles), results.contenders[c].label,
                   std::to_string(k + 1), fmt::format("{:.9g}", frames[k].median),
                   fmt::format("{:.9g}", frames[k].low), fmt::format("{:.9g}", frames[k].high)});
      }
    }
  }
  return table;
}

chart::Chart bench_chart(const BenchResults& results) {
  chart::Chart chart;
  chart.title = finding(results);
  chart.subtitle = fmt::format(
      "{}: time of stepping alone at each method's default settings, errors not equal. Medians and "
      "quartiles over interleaved repeats. {}",
      results.scene.title, options::machine());
  if (results.blocks.size() > 1) chart.panels.push_back(growth_panel(results));
  chart.panels.push_back(frames_panel(results));
  const chart::Panel paper = ratio_panel(results);
  if (results.blocks.size() > 1 && !paper.series.front().points.empty()) {
    chart.panels.push_back(paper);
  }
  chart.columns = chart.panels.size();
  chart.width = static_cast<int>(200 + 480 * chart.panels.size());
  return chart;
}

std::string bench_json(const BenchResults& results) {
  program::Json json = {{"scene", results.scene.file.string()},
                        {"machine", options::machine()},
                        {"against", results.against},
                        {"rows", program::Json::array()},
                        {"paper_ratio", program::Json::array()},
                        {"equal_error", program::Json::array()}};
  for (const BenchBlock& block : results.blocks) {
    for (std::size_t c = 0; c < results.contenders.size(); ++c) {
      json["rows"].push_back(json_of(results, block, c));
    }
    for (const study::PaperSetting& one : block.paper.settings) {
      json["paper_ratio"].push_back(json_of(one));
    }
    for (const study::EqualError& one : block.paper.equal)
      json["equal_error"].push_back(json_of(one));
  }
  return program::json_text(json) + "\n";
}

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
