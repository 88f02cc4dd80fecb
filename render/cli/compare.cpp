// taut compare: methods side by side in one clip, with the truth in each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/film/comparison.h"
#include "render/film/fingerprint.h"
#include "render/film/frame_folder.h"
#include "render/film/video.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/frame_list.h"
#include "render/program/json.h"
#include "render/program/note.h"
#include "render/program/progress.h"
#include "render/program/terminal.h"
#include "scenes/files/error.h"
#include "scenes/load/default_stage.h"
#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/truth/truth.h"

namespace taut::cli {
namespace compare_command {
namespace {

constexpr std::size_t kCells = 6;  // unless --methods chooses
constexpr double kCpuCap = 60;     // s, of one method's stepping
constexpr double kScored = 1e-3;   // shares of the length: errors from there on are scored

struct Options {
  options::StudyOptions study;
  std::optional<std::string> frames;
  std::string size, backend = "auto";
  int fps = 0, samples = 4;
  bool no_video = false, over = false;
};

/// Those that are asked for; otherwise every method that this build has and that follows the
/// world, and forms of them until six cells are full.
std::vector<options::Contender> contenders(const options::StudyOptions& options,
                                           const World& world) {
  std::vector<options::Contender> all = options::contenders_on(options, world);
  if (!options.methods.empty()) return all;
  std::erase_if(all, [](const options::Contender& c) { return !c.method->missing.empty(); });
  const auto is_form = [](const options::Contender& c) {
    return c.label.find(':') != std::string::npos;
  };
  std::vector<options::Contender> chosen;
  for (const bool form : {false, true})
    for (const options::Contender& one : all)
      if (is_form(one) == form && chosen.size() < kCells) chosen.push_back(one);
  return chosen;
}

/// The candidate of a contender on this scene: the scene's own settings where they are for it.
study::Candidate candidate_on(const scenes::Scene& scene, const options::Contender& contender) {
  study::Candidate candidate = contender.candidate;
  if (scene.method.name == candidate.method)
    for (const auto& [name, value] : scene.method.settings) candidate.settings.emplace(name, value);
  return candidate;
}

/// The mean distance (m) of the segments in each frame that both have, of the first `most`.
std::vector<double> distances(std::span<const Snapshot> frames, std::span<const Snapshot> from,
                              std::size_t most) {
  std::vector<double> list;
  for (std::size_t k = 0; k < std::min({frames.size(), from.size(), most}); ++k)
    list.push_back(study::segment_difference(frames[k], from[k]));
  return list;
}

/// Their mean; not a number where there are fewer than `frames`, or only the start.
double mean(const std::vector<double>& distances, std::size_t frames) {
  if (distances.size() < std::max<std::size_t>(frames, 2)) return NAN;
  return std::reduce(distances.begin(), distances.end()) / double(distances.size());
}

/// The table's numbers, of one method; not a number where there is none.
struct Measured {
  double from_paper = NAN, from_truth = NAN;  // m
  double stretch = NAN, drift = NAN;          // shares
  double cpu = NAN;                           // s per frame
};

/// Runs everything, and measures it.
std::pair<film::Comparison, std::vector<Measured>> compare(
    const scenes::Scene& scene, const std::vector<options::Contender>& contenders, bool quiet) {
  study::Problem problem{scene.world, {}, scene.timeline};
  for (int k = 0; k < scene.frames(); ++k) problem.times.push_back(double(k) / scene.fps);
  const double length = scene.world.connectors.front().length;
  if (!quiet) program::note("solving the truth\n");
  truth::TruthOptions accuracy;
  if (length > 0) accuracy.scored_error = kScored * length;
  truth::Reference truth = [&] {
    // Two solvers, the first of them three times: no more than so many frames.
    program::Progress progress("solving the truth", "frames", 4 * problem.times.size(), true);
    std::uint64_t done = 0;
    return truth::solve_truth(scene.world, problem.times, accuracy, scene.timeline, [&] {
      render::stop_if_interrupted();
      progress.update(++done);
    });
  }();
  const std::size_t predictable =
      std::size_t(std::ranges::upper_bound(problem.times, truth.horizon) - problem.times.begin());

  program::Progress running("running", "methods", contenders.size(), true);
  std::uint64_t finished = 0;
  const auto run_of = [&](const study::Candidate& candidate) {
    if (!quiet) program::note("running {}\n", study::describe(candidate));
    study::Run run = study::run(problem, candidate, kCpuCap, render::stop_if_interrupted);
    running.update(++finished);
    return run;
  };
  std::vector<study::Run> runs;
  const study::Run* paper = nullptr;
  for (const options::Contender& contender : contenders) {
    if (contender.method->missing.empty()) {
      runs.push_back(run_of(candidate_on(scene, contender)));
    } else {
      study::Run& missing = runs.emplace_back();
      missing.end = study::Run::End::diverged;
      missing.reason = contender.method->missing;
    }
  }
  // The paper's Figure 6 measures from dynamic constraints.
  const MethodInfo& by_constraints = *find_method(PaperRole::dynamic_constraints);
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (contenders[i].label == by_constraints.name) paper = &runs[i];
  study::Run beside;
  if (!paper && follows(by_constraints, scene.world)) {
    beside = run_of({std::string(by_constraints.name), {}});
  }
  if (!paper) paper = &beside;

  film::Comparison result;
  std::vector<Measured> measured;
  result.times = problem.times;
  result.truth = std::move(truth.frames);
  result.horizon = truth.horizon;
  result.self_error = truth.self_error;
  const bool by_paper = !paper->frames.empty();
  result.table.columns = {"method"};
  if (by_paper) result.table.columns.push_back("from dynamic constraints, mm");
  for (const char* column :
       {"from the truth, mm", "largest stretch, %", "energy drift, %", "CPU µs per frame"}) {
    result.table.columns.push_back(column);
  }
  result.measured_from = predictable > 1 ? "the truth" : "dynamic constraints";
  const bool closed =
      is_closed(scene.world) && scene.timeline.empty() && energy_scale(scene.world) > 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const study::Run& run = runs[i];
    film::ComparedMethod method{contenders[i].label,
                                study::describe(candidate_on(scene, contenders[i]).settings),
                                contenders[i].style,
                                {},
                                run.reason,
                                {},
                                {}};
    method.stretch = run.stretch;
    const auto from_truth = distances(run.frames, result.truth, predictable);
    const auto from_paper = distances(run.frames, paper->frames, problem.times.size());
    method.distance = predictable > 1 ? from_truth : from_paper;
    Measured& m = measured.emplace_back();
    m.from_paper = mean(from_paper, problem.times.size());
    m.from_truth = mean(from_truth, predictable);
    if (const double frames = double(run.frames.size()); frames > 0) {
      m.stretch = run.stretch_max;
      if (closed) {
        // Contact takes some, and strings where they go taut.
        const bool takes = has_contact(scene.world) || has_strings(scene.world);
        const double lost = takes ? 0 : run.energy_loss;
        m.drift = std::max(run.energy_gain, lost) / energy_scale(scene.world);
      }
      m.cpu = run.cpu / frames;
    }
    std::vector<std::string> row{method.label};
    if (by_paper) row.push_back(options::rounded(1e3 * m.from_paper));
    for (const double value : {1e3 * m.from_truth, 100 * m.stretch, 100 * m.drift, 1e6 * m.cpu}) {
      row.push_back(options::rounded(value));
    }
    result.table.add(std::move(row));
    method.frames = run.frames;
    result.methods.push_back(std::move(method));
  }
  return {std::move(result), std::move(measured)};
}

std::string report(const Options& options, const scenes::Scene& scene,
                   const film::Comparison& comparison, const std::vector<Measured>& measured,
                   const std::string& video) {
  program::Json json = {
      {"scene", options.study.scene},           {"title", scene.title},
      {"size_px", {scene.width, scene.height}}, {"fps", scene.fps},
      {"horizon_s", comparison.horizon},        {"self_error_m", comparison.self_error},
      {"methods", program::Json::array()}};
  for (std::size_t i = 0; i < comparison.methods.size(); ++i) {
    const film::ComparedMethod& method = comparison.methods[i];
    const Measured& m = measured[i];
    json["methods"].push_back(
        {{"method", method.label},
         {"settings", method.settings},
         {"frames", method.frames.size()},
         {"failure", method.failure},
         {"from_dynamic_constraints_mm", program::number_or_null(1e3 * m.from_paper)},
         {"from_truth_mm", program::number_or_null(1e3 * m.from_truth)},
         {"stretch_max", program::number_or_null(m.stretch)},
         {"energy_drift", program::number_or_null(m.drift)},
         {"cpu_us_per_frame", program::number_or_null(1e6 * m.cpu)}});
  }
  if (!video.empty()) json["video"] = video;
  return json.dump(2) + "\n";
}

int compare(const program::Common& common, const Options& options) {
  scenes::Scene scene = options::study_scene(options.study, {}, true);
  if (options.fps > 0) scene.fps = options.fps;
  if (!options.size.empty())
    std::tie(scene.width, scene.height) = program::picture_size(options.size);
  scenes::complete_stage(scene, options::scene_changes(options.study.inputs.set),
                         render::stop_if_interrupted);
  if (!options.no_video && (scene.width % 2 || scene.height % 2))
    throw program::Misuse(
        fmt::format("a video of {}x{} is not possible: H.264 (yuv420p) needs even sides",
                    scene.width, scene.height));
  const std::vector<options::Contender> chosen = contenders(options.study, scene.world);
  const std::vector<int> frames = program::frame_list(options.frames, scene.frames());
  if (!options.no_video) film::require_ffmpeg();

  const std::string name = options::scene_name(options.study.scene);
  const std::filesystem::path out = options::results_folder(
      options.study.scene, options.study.out, options.study.inputs.several(), "out/compare");
  const gl::Context context(gl::backend_named(options.backend), common.threads);
  const std::string layout = options.over ? "_over" : "";
  film::FrameFolder folder(out / ("frames" + layout), false, {scene.width, scene.height});
  const auto [comparison, measured] = compare(scene, chosen, common.quiet);
  film::ComparisonFilm film(context, scene, comparison, scene.width, scene.height, options.samples,
                            options.over ? film::Layout::over : film::Layout::beside);
  std::vector<std::filesystem::path> files;
  {
    program::Progress progress("rendering", "frames", frames.size(), common.quiet);
    for (const int frame : frames) {
      render::stop_if_interrupted();
      folder.put(frame, film::program_fingerprint(), film.draw(std::size_t(frame)));
      files.push_back(folder.file(frame));
      progress.update(files.size());
    }
    folder.finish();
  }
  std::string video;
  if (!options.no_video) {
    video = (out / (name + layout + ".mp4")).string();
    film::encode_video(files, scene.fps, video);
  }
  options::write_csv(comparison.table, out / "compare");
  const std::string json = report(options, scene, comparison, measured, video);
  render::AtomicFile record(out / "compare.json");
  record.write(json);
  record.commit();
  render::write_output(common.json ? json : program::table_text(comparison.table));
  if (!common.quiet)
    program::note("{}\n", video.empty() ? (out / ("frames" + layout)).string() : video);
  return program::kDone;
}

}  // namespace
}  // namespace compare_command

void add_compare(CLI::App& app, program::Program& program) {
  using namespace compare_command;
  program::Command command = program::add_command(
      app, program, "compare", "Show methods side by side in one clip, scored against the truth",
      "  taut compare scenes/rope_drop.toml\n"
      "  taut compare scenes/rope_swing.toml --methods impulse,impulse:as-printed,direct\n"
      "  taut compare scenes/rope_drop.toml --over\n"
      "  taut compare scenes/rope_swing.toml --frames 0-30 --size 960x540 --no-video");
  auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->study.inputs);
  command.add_option("--out", options->study.out,
                     "The clip's folder; default: below out/compare, by the scene's path");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, with commas; default: six")
      .delimiter(',');
  command.add_option("--frames", options->frames, "Frames to make, as A-B,C; default all");
  command.add_option("--size", options->size, "WxH in pixels; default the scene's");
  command.add_option("--fps", options->fps, "Frames per second; default the scene's")
      .range(1, 1000);
  command.add_option("--samples", options->samples, "Samples per pixel; default 4").range(1, 64);
  command.add_option("--backend", options->backend, "auto, egl or osmesa")
      .one_of({"auto", "egl", "osmesa"});
  command.add_flag("--over", options->over,
                   "All methods in one panel, each in its colour, instead of side by side");
  command.add_flag("--no-video", options->no_video, "Frames only");
  options->study.follows = options::Follows::pins_and_cuts;
  options->study.among_obstacles = true;
  command.callback([&program, options] {
    program.run = [&program, options] {
      return options::for_each_study(options->study, program.common,
                                     [&](const options::StudyOptions& one) {
                                       Options of_one = *options;
                                       of_one.study = one;
                                       return compare(program.common, of_one);
                                     });
    };
  });
}

}  // namespace taut::cli
