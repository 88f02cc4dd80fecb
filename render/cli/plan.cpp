// taut plan: the cheapest model of a scene that nobody can tell from the reference solution.
#include "render/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/study_target.h"
#include "scenes/files/files.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"

namespace taut::cli {
namespace plan_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  options::SceneOptions inputs;
  std::string scene, tolerance;
  bool write = false;
  double budget = 120;  // s of CPU time
};

/// "1px" or "0.5mm".
planning::Asked asked_for(const std::string& text, const scenes::Scene& scene) {
  const auto length = scenes::read_length(text);
  if (!length) {
    throw program::Misuse(
        fmt::format("--tolerance {}: expected a number above 0 and px or mm, as in 1px", text));
  }
  planning::Asked asked{.tolerance = {{}, length->number}, .unit = std::string(length->unit)};
  if (asked.unit == "mm") {
    asked.per_metre = 1e3;
    asked.tolerance.distance = [](const Vec3& at, const Vec3& truth, double) {
      return 1e3 * (at - truth).norm();
    };
    return asked;
  }
  const auto metric = studies::pixels_of(scene);
  if (!metric) {
    throw program::Misuse(fmt::format("--tolerance {}: {} has no camera; give the tolerance in mm",
                                      text, scene.file.string()));
  }
  asked.tolerance.distance = metric->distance;
  constexpr double kNear = 1e-4;  // m
  constexpr int kLooks = 1000;
  for (int k = 0; k < scene.frames(); k += std::max(1, scene.frames() / kLooks)) {
    const double time = double(k) / scene.fps;
    for (const auto& particles : snapshot(scene.world).connectors) {
      for (const Vec3& at : particles) {
        for (const Vec3 side : {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}) {
          const double pixels = metric->distance(at + kNear * side, at, time);
          if (std::isfinite(pixels)) asked.per_metre = std::max(asked.per_metre, pixels / kNear);
        }
      }
    }
  }
  if (asked.per_metre == 0)
    throw program::Misuse("the camera never sees where the connector starts");
  return asked;
}

/// The scene file, to be written once its plan is found: says beforehand if it cannot be.
class PlanFile {
 public:
  explicit PlanFile(const fs::path& scene)
      : scene_(fs::canonical(scene)), stamp_(scenes::plan_stamp(scene)) {
    if ((fs::status(scene_).permissions() & fs::perms::owner_write) == fs::perms::none) {
      throw render::CannotWrite(
          fmt::format("{}: is read-only, and --write would change it", scene.string()));
    }
    file_.emplace(scene_);
  }

  void write(const scenes::Plan& plan) {
    if (scenes::plan_stamp(scene_) != stamp_) {
      throw render::CannotWrite(
          fmt::format("{}: has changed while it was planned; plan it again", scene_.string()));
    }
    file_->write(scenes::with_plan(scenes::read_bytes(scene_), plan));
    file_->commit();
  }

 private:
  fs::path scene_;
  std::uint64_t stamp_;
  std::optional<render::AtomicFile> file_;
};

int run(const Options& options, const program::Common& common) {
  const std::vector<scenes::SceneChange> changes = options::scene_changes(options.inputs.set);
  if (options.write && !changes.empty()) {
    throw program::Misuse("--write: the plan would be of another scene than the file's (--set)");
  }
  if (options.write && options.scene == "-") {
    throw program::Misuse("--write: standard input is no file to write the plan into");
  }
  const scenes::Scene scene = scenes::load_scene(options.scene, true, changes);
  if (scene.world.connectors.empty()) {
    throw program::Misuse(fmt::format("{}: has no connector to plan for", options.scene));
  }
  const planning::Asked asked = asked_for(options.tolerance, scene);
  const std::uint64_t stamp = scenes::plan_stamp(scene.file);
  std::optional<PlanFile> file;
  if (options.write) file.emplace(scene.file);

  const planning::Planned planned = planning::make_plan(scene, changes, asked, options.tolerance,
                                                        stamp, options.budget, common.quiet);
  if (file) file->write(planned.plan);
  if (common.json) {
    render::write_output(planning::plan_json(planned));
  } else {
    program::write_text(planning::plan_text(planned));
  }
  return program::kDone;
}

}  // namespace
}  // namespace plan_command

void add_plan(CLI::App& app, program::Program& program) {
  using namespace plan_command;
  program::Command command =
      program::add_command(app, program, "plan", "Find the cheapest settings within an error",
                           R"(  taut plan scenes/rope_swing.toml --tolerance 1px
  taut plan scenes/nunchaku.toml --tolerance 0.5mm --budget 3600
  taut plan scenes/rope_swing.toml --tolerance 1px --write
  taut render scenes/rope_swing.toml --planned

It chooses the number of particles or a massless span, rigid bodies or links in their place, the
stretch, bending, twist and air to neglect, the method with its settings, and the exposures of the
motion blur. Costs are counts of work, so the same scene has the same plan on every machine, unless
--budget leaves something out. The reference is the scene as written, solved to convergence. While
the motion is predictable, the plan compares every particle and the ends of every body, at every
frame and at all that the clip shows between frames; after that, energy, stretch and speeds. Pixels
are those of the scene's shots, in a picture as high as the scene's.

The reference solution may use 0.6 of --budget. Models and settings that exceed the rest are left
out, and their number is printed.

--write stores the plan in the scene file, as its table [plan]; render and simulate use it with
--planned. They refuse it if the scene, or the motion by the program's method, has changed since.
--json prints all of it. Exit codes: 0 found, 2 no method comes so near within the budget, or the
tolerance makes no sense, 3 bad scene, 6 the scene file cannot be written, 130 interrupted)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs);
  command
      .add_option("--tolerance", options->tolerance,
                  "Largest position error of any point: 1px on the picture, or 0.5mm")
      .required();
  command
      .add_option("--budget", options->budget,
                  fmt::format("CPU time, s, approximately; default: {}", options->budget))
      .positive();
  command.add_flag("--write", options->write, "Write the plan into the scene file");
  command.callback([options, &program] {
    program.run = [options, &program] {
      return options::for_each_scene(options->inputs, program.common,
                                     [&](const std::string& scene) {
                                       Options one = *options;
                                       one.scene = scene;
                                       return run(one, program.common);
                                     });
    };
  });
}

}  // namespace taut::cli
