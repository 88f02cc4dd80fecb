// taut compare: methods side by side in one clip, with the truth in each.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/frame_list.h"
#include "render/cli/note.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/comparison.h"
#include "render/fingerprint.h"
#include "render/frame_folder.h"
#include "render/interrupt.h"
#include "render/video.h"
#include "scenes/error.h"
#include "sim/measure.h"
#include "sim/study/accuracy.h"
#include "sim/study/run.h"
#include "sim/truth/truth.h"

namespace taut::cli {
namespace {

constexpr std::size_t kCells = 6;  // unless --methods chooses
constexpr double kCpuCap = 60;     // s, of one method's stepping
constexpr double kScored = 1e-3;   // shares of the length: errors from there on are scored
constexpr const char* kPaper = "dynamic-constraints";  // by what the paper's Figure 6 measures

struct Options {
  StudyOptions study;
  std::optional<std::string> frames;
  std::string size, backend = "auto";
  int fps = 0, samples = 4;
  bool no_video = false;
};

/// Those that are asked for; otherwise every method that this build has, and forms of them until
/// six cells are full.
std::vector<Contender> contenders(const StudyOptions& options) {
  std::vector<Contender> all = chosen_contenders(options);
  if (!options.methods.empty()) return all;
  std::erase_if(all, [](const Contender& c) { return !c.method->missing.empty(); });
  const auto is_form = [](const Contender& c) { return c.label.find(':') != std::string::npos; };
  std::vector<Contender> chosen;
  for (const bool form : {false, true})
    for (const Contender& one : all)
      if (is_form(one) == form && chosen.size() < kCells) chosen.push_back(one);
  return chosen;
}

/// The candidate of a contender on this scene: the scene's own settings where they are for it.
Candidate candidate_on(const Scene& scene, const Contender& contender) {
  Candidate candidate = contender.candidate;
  if (scene.method.name == candidate.method)
    for (const auto& [name, value] : scene.method.settings) candidate.settings.emplace(name, value);
  return candidate;
}

/// The mean distance (m) of the segments in each frame that both have, of the first `most`.
std::vector<double> distances(std::span<const Snapshot> frames, std::span<const Snapshot> from,
                              std::size_t most) {
  std::vector<double> list;
  for (std::size_t k = 0; k < std::min({frames.size(), from.size(), most}); ++k)
    list.push_back(segment_difference(frames[k], from[k]));
  return list;
}

/// Their mean in mm; nothing where there are fewer than `frames`, or only the start.
std::string mean_text(const std::vector<double>& distances, std::size_t frames) {
  if (distances.size() < std::max<std::size_t>(frames, 2)) return "-";
  return rounded(1e3 * std::reduce(distances.begin(), distances.end()) / double(distances.size()));
}

/// Runs everything, and measures it.
Comparison compare(const Scene& scene, const std::vector<Contender>& contenders, bool quiet) {
  Problem problem{scene.world, {}, scene.timeline};
  for (int k = 0; k < scene.frames(); ++k) problem.times.push_back(double(k) / scene.fps);
  const double length = scene.world.connectors.front().length;
  if (!quiet) note("solving the truth\n");
  TruthOptions accuracy;
  if (length > 0) accuracy.scored_error = kScored * length;
  Truth truth = solve_truth(scene.world, problem.times, accuracy, scene.timeline);
  const std::size_t predictable =
      std::size_t(std::ranges::upper_bound(problem.times, truth.horizon) - problem.times.begin());

  const auto run_of = [&](const Candidate& candidate) {
    stop_if_interrupted();
    if (!quiet) note("running {}\n", describe(candidate));
    return taut::run(problem, candidate, kCpuCap);
  };
  std::vector<Run> runs;
  const Run* paper = nullptr;
  for (const Contender& contender : contenders) {
    if (contender.method->missing.empty()) {
      runs.push_back(run_of(candidate_on(scene, contender)));
    } else {
      Run& missing = runs.emplace_back();
      missing.end = Run::End::diverged;
      missing.reason = contender.method->missing;
    }
  }
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (contenders[i].label == kPaper) paper = &runs[i];
  Run beside;
  if (!paper) beside = run_of({kPaper, {}}), paper = &beside;

  Comparison result;
  result.times = problem.times;
  result.truth = std::move(truth.frames);
  result.horizon = truth.horizon;
  result.self_error = truth.self_error;
  result.table.columns = {"method",
                          "from dynamic constraints, mm",
                          "from the truth, mm",
                          "largest stretch, %",
                          "energy drift, %",
                          "CPU us per frame"};
  result.measured_from = predictable > 1 ? "the truth" : "dynamic constraints";
  const bool closed =
      is_closed(scene.world) && scene.timeline.empty() && energy_scale(scene.world) > 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i];
    ComparedMethod method{contenders[i].label,
                          describe(candidate_on(scene, contenders[i]).settings),
                          contenders[i].style,
                          {},
                          run.reason,
                          {},
                          {}};
    method.stretch = run.stretch;
    const auto from_truth = distances(run.frames, result.truth, predictable);
    const auto from_paper = distances(run.frames, paper->frames, problem.times.size());
    method.distance = predictable > 1 ? from_truth : from_paper;
    const double frames = double(run.frames.size());
    const double drift = std::max(run.energy_gain, run.energy_loss) / energy_scale(scene.world);
    result.table.add({method.label, mean_text(from_paper, problem.times.size()),
                      mean_text(from_truth, predictable),
                      frames > 0 ? rounded(100 * run.stretch_max) : "-",
                      frames > 0 && closed ? rounded(100 * drift) : "-",
                      frames > 0 ? rounded(1e6 * run.cpu / frames) : "-"});
    method.frames = run.frames;
    result.methods.push_back(std::move(method));
  }
  return result;
}

std::string report(const Options& options, const Scene& scene, const Comparison& comparison,
                   const std::string& video) {
  nlohmann::ordered_json json = {{"scene", options.study.scene},
                                 {"title", scene.title},
                                 {"size", {scene.width, scene.height}},
                                 {"fps", scene.fps},
                                 {"horizon", comparison.horizon},
                                 {"self_error", comparison.self_error},
                                 {"methods", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < comparison.methods.size(); ++i) {
    const ComparedMethod& method = comparison.methods[i];
    nlohmann::ordered_json entry = {{"settings", method.settings},
                                    {"frames", method.frames.size()},
                                    {"failure", method.failure}};
    for (std::size_t c = 0; c < comparison.table.columns.size(); ++c)
      entry[comparison.table.columns[c]] = comparison.table.rows[i][c];
    json["methods"].push_back(entry);
  }
  if (!video.empty()) json["video"] = video;
  return json.dump(2) + "\n";
}

int compare(const Common& common, const Options& options) {
  Scene scene = study_scene(options.study, {}, true);
  if (!scene.stage)
    throw BadScene(
        fmt::format("{}: has no [stage], so there is nothing to draw", options.study.scene));
  if (options.fps > 0) scene.fps = options.fps;
  if (!options.size.empty()) std::tie(scene.width, scene.height) = picture_size(options.size);
  if (!options.no_video && (scene.width % 2 || scene.height % 2))
    throw Misuse(fmt::format("a video of {}x{} is not possible: H.264 (yuv420p) needs even sides",
                             scene.width, scene.height));
  const std::vector<Contender> chosen = contenders(options.study);
  const std::vector<int> frames = frame_list(options.frames, scene.frames());
  if (!options.no_video) require_ffmpeg();

  const std::string name = std::filesystem::path(options.study.scene).stem().string();
  const std::filesystem::path out = options.study.out.empty()
                                        ? std::filesystem::path("out/compare") / name
                                        : std::filesystem::path(options.study.out);
  const Context context(backend_named(options.backend), common.threads);
  FrameFolder folder(out / "frames", false);
  const Comparison comparison = compare(scene, chosen, common.quiet);
  ComparisonFilm film(context, scene, comparison, scene.width, scene.height, options.samples);
  std::vector<std::filesystem::path> files;
  {
    Progress progress("rendering", "frames", frames.size(), common.quiet);
    for (const int frame : frames) {
      stop_if_interrupted();
      folder.put(frame, program_fingerprint(), film.draw(std::size_t(frame)));
      files.push_back(folder.file(frame));
      progress.update(files.size());
    }
    folder.finish();
  }
  std::string video;
  if (!options.no_video) {
    video = (out / (name + ".mp4")).string();
    encode_video(files, scene.fps, video);
  }
  write_csv(comparison.table, out / "compare");
  const std::string json = report(options, scene, comparison, video);
  AtomicFile record(out / "compare.json");
  record.write(json);
  record.commit();
  write_output(common.json ? json : to_text(comparison.table));
  if (!common.quiet) note("{}\n", video.empty() ? (out / "frames").string() : video);
  return kDone;
}

}  // namespace

void add_compare(CLI::App& app, Program& program) {
  CLI::App& command = add_command(
      app, program, "compare", "Show methods side by side in one clip, judged by the truth",
      "  taut compare scenes/rope_drop.toml\n"
      "  taut compare scenes/rope_swing.toml --methods impulse,impulse:as-printed,direct\n"
      "  taut compare scenes/rope_swing.toml --frames 0-30 --size 960x540 --no-video");
  auto options = std::make_shared<Options>();
  command.add_option("scene", options->study.scene, "The scene file")->required();
  command.add_option("--out", options->study.out, "The clip's folder; default out/compare/NAME");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to compare, METHOD or METHOD:FORM, with commas; default: six")
      ->delimiter(',');
  command.add_option("--frames", options->frames, "Frames to make, as A-B,C; default all");
  command.add_option("--size", options->size, "WxH in pixels; default the scene's");
  command.add_option("--fps", options->fps, "Frames per second; default the scene's")
      ->check(CLI::Range(1, 1000));
  command.add_option("--samples", options->samples, "Samples per pixel; default 4")
      ->check(CLI::Range(1, 64));
  command.add_option("--backend", options->backend, "auto, egl or osmesa")
      ->check(CLI::IsMember({"auto", "egl", "osmesa"}));
  command.add_flag("--no-video", options->no_video, "Frames only");
  options->study.follows = Follows::pins_and_cuts;
  command.callback([&program, options] {
    program.run = [&program, options] { return compare(program.common, *options); };
  });
}

}  // namespace taut::cli
