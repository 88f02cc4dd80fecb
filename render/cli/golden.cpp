// taut golden: pictures and motions that are kept, and compared with what their scenes do now.
#include "render/golden/golden.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/clip/goldens.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "sim/motion/printable.h"

namespace taut::cli {
namespace golden_command {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
  std::string action, folder, out, backend = "auto";
  std::vector<std::string> only;
  bool simulate = false;
};

int check(clips::Goldens& goldens, const fs::path& out, const program::Common& common) {
  Json frames = Json::array(), trajectories = Json::array();
  std::vector<golden::GoldenFailure> failures;
  {
    program::Progress progress("checking", "goldens",
                               goldens.frames().size() + goldens.trajectories().size(),
                               common.quiet);
    for (const scenes::GoldenTrajectory& trajectory : goldens.trajectories()) {
      render::stop_if_interrupted();
      const golden::TrajectoryComparison result = goldens.check(trajectory);
      if (!result.failure.empty()) failures.push_back({trajectory.name, result.failure, false});
      trajectories.push_back(
          {{"name", trajectory.name},
           {"scene", trajectory.scene.string()},
           {"last_frame", trajectory.last},
           {"method", trajectory.method.name},
           {"settings", options::settings_json(with_defaults(trajectory.method))},
           {"same", result.failure.empty()},
           {"failure", result.failure},
           {"distance", result.distance}});
      progress.update(trajectories.size());
    }
    for (const scenes::GoldenFrame& frame : goldens.frames()) {
      render::stop_if_interrupted();
      const clips::FrameResult result = goldens.check(frame);
      const fs::path folder = out / frame.name;
      render::remove_output(folder);
      if (!result.failure.empty()) {
        failures.push_back({frame.name, result.failure, result.actual.has_value()});
        if (result.actual) {
          clips::write_picture(folder / "actual.png", *result.actual);
          clips::write_picture(folder / "golden.png", *result.golden);
          clips::write_picture(folder / "difference.png",
                               golden::amplified_difference(*result.actual, *result.golden));
        }
      }
      const golden::PictureDifference& d = result.comparison.difference;
      frames.push_back({{"name", frame.name},
                        {"scene", frame.scene.string()},
                        {"frame", frame.frame},
                        {"method", frame.method.name},
                        {"settings", options::settings_json(with_defaults(frame.method))},
                        {"same", result.failure.empty()},
                        {"failure", result.failure},
                        {"judged_as", golden::name_of(result.comparison.tier)},
                        {"share_above_2", d.above_2},
                        {"largest", d.largest},
                        {"mean_shift", d.mean_shift},
                        {"share_unlike_neighbours", d.near_above_8},
                        {"state_distance", result.distance}});
      progress.update(frames.size() + trajectories.size());
    }
  }
  const std::string report =
      program::json_text(
          Json({{"failed", failures.size()}, {"frames", frames}, {"trajectories", trajectories}})) +
      "\n";
  clips::write_text(out / "report.json", report);
  if (failures.empty()) {
    render::remove_output(out / "index.html");
  } else {
    clips::write_text(out / "index.html", golden::golden_page(failures));
  }
  const std::size_t all = frames.size() + trajectories.size();
  std::string text;
  for (const golden::GoldenFailure& failure : failures)
    text += fmt::format("{}: {}\n", printable(failure.name), printable(failure.verdict));
  text += failures.empty() ? fmt::format("{} as kept\n", all)
                           : fmt::format("{} of {} differ: {}\n", failures.size(), all,
                                         (out / "index.html").string());
  if (common.json) {
    render::write_output(report);
  } else {
    program::write_text(text);
  }
  return failures.empty() ? program::kDone : program::kDiffers;
}

int run(const Options& options, const program::Common& common) {
  clips::Goldens goldens(options.folder, options.only, gl::backend_named(options.backend),
                         common.threads);
  fs::path folder = fs::path(options.folder).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  if (options.action == "check")
    return check(
        goldens,
        options.out.empty() ? fs::path("out/golden") / folder.filename() : fs::path(options.out),
        common);
  Json accepted = Json::array();
  std::string text;
  const auto took_over = [&](const std::string& name, const std::string& change) {
    accepted.push_back({{"name", name}, {"change", change}});
    text += fmt::format("{}: {}\n", printable(name), printable(change));
    render::stop_if_interrupted();
  };
  for (const scenes::GoldenFrame& frame : goldens.frames())
    took_over(frame.name, goldens.accept(frame, options.simulate));
  for (const scenes::GoldenTrajectory& trajectory : goldens.trajectories())
    took_over(trajectory.name, goldens.accept(trajectory, options.simulate));
  if (common.json) {
    render::write_output(program::json_text(Json({{"accepted", accepted}})) + "\n");
  } else {
    program::write_text(text);
  }
  return program::kDone;
}

}  // namespace
}  // namespace golden_command

void add_golden(CLI::App& app, program::Program& program) {
  using namespace golden_command;
  program::Command command = program::add_command(app, program, "golden",
                                                  "Compare pictures and motions with accepted ones",
                                                  R"(  taut golden check tests/golden/scenes
  taut golden accept tests/golden/scenes --only throw

A golden.toml in the folder names pictures and motions:
  size = [320, 180]
  [frames.throw]
  scene = "scenes/nunchaku.toml"
  time = 2.7
  method = { name = "direct", tolerance = 1e-5 }  # default: the scene's
  within = 1e-3                                   # m; default: twice the method's tolerance
  [trajectories.swing]
  scene = "scenes/rope_swing.toml"
  until = 0.5

`check` draws each picture from its kept state and compares it by tolerance: at most 0.01% of the
pixels differ by more than 2 of 255, none by more than 16. A driver other than the one that drew the
golden picture may move edges by a pixel. `check` also simulates each scene and fails if a state is
further than `within` from the kept one. `within` is twice the tolerance of a method that has one,
and 1e-6 m otherwise, on every machine. Pictures that differ, report.json and index.html are written
to out/golden. `accept` keeps today's pictures, drawn from the kept states; if a scene
moved by more than `within`, it keeps today's states.)");
  const auto options = std::make_shared<Options>();
  command.add_option("action", options->action, "check or accept")
      .required()
      .one_of({"check", "accept"});
  command.add_option("folder", options->folder, "Folder with golden.toml").required();
  command.add_option("--only", options->only, "Only this picture or motion; may be repeated")
      .one_value_each();
  command.add_option("--out", options->out,
                     "Folder for pictures that differ; default: out/golden/NAME");
  command.add_flag("--simulate", options->simulate,
                   "accept: keep today's states even if they are within the limit");
  command.add_option("--backend", options->backend, "OpenGL backend: auto, egl or osmesa")
      .one_of({"auto", "egl", "osmesa"});
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
