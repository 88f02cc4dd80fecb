// taut classify: the class of the motion of each method in each scene.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "render/atomic_file.h"
#include "render/interrupt.h"
#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/json.h"
#include "render/program/progress.h"
#include "render/program/terminal.h"
#include "render/study/stability_study.h"
#include "render/study/study_target.h"
#include "sim/study/stability.h"

namespace taut::cli {
namespace {

struct Options {
  StudyOptions study;  // of its fields only inputs and methods
  double cap = 5;      // s of CPU time
  bool markdown = false, no_truth = false;
};

/// The class, and the number that it was found by.
std::string words(const Run& run, const Classification& found) {
  switch (found.motion_class) {
    case MotionClass::failed:
      return run.end == Run::End::diverged
                 ? fmt::format("failed: diverged at {} s", rounded(run.failed_at))
                 : "failed: gained " + percent(found.gain) + " energy";
    case MotionClass::stretched:
      return "stretched " + percent(found.stretch);
    case MotionClass::over_damped:
      return "over-damped: lost " + percent(found.loss);
    case MotionClass::over_cap:
      return fmt::format("over the CPU cap at {} s", rounded(run.reached));
    case MotionClass::accurate:
      return "accurate: " + percent(found.error);
    case MotionClass::plausible:
      return std::isnan(found.error) ? "plausible" : "plausible: off by " + percent(found.error);
  }
  return "";
}

/// The contender at its defaults. A scene whose step is a whole frame asks every method that has a
/// step to take that.
Candidate candidate_for(const Contender& contender, const Scene& scene,
                        const std::vector<std::string>& set) {
  Candidate candidate = contender.candidate;
  for (const auto& [name, value] : settings_of(*contender.method, set)) {
    candidate.settings[name] = value;
  }
  if (const std::string wrong = complaint(*contender.method, candidate.settings); !wrong.empty()) {
    throw Misuse(fmt::format("--set: {}", wrong));
  }
  const auto step = scene.method.settings.find("step");
  if (step == scene.method.settings.end() ||
      number(scene.method.settings, "step") * scene.fps < 0.999) {
    return candidate;
  }
  if (std::ranges::find(contender.method->settings, "step", &SettingInfo::name) !=
      contender.method->settings.end()) {
    candidate.settings.insert(*step);
  }
  return candidate;
}

/// The class of each contender in a scene.
struct Classified {
  Scene scene;
  std::string file;
  std::optional<double> horizon;  // s
  struct Method {
    const Contender* contender;
    std::optional<Run> run;  // none: this build lacks it
    Classification classification = {};
  };
  std::vector<Method> methods = {};
};

Classified classified(const Options& options, const std::string& file,
                      const std::vector<Contender>& contenders) {
  StudyOptions study = options.study;
  study.scene = file;
  study.follows = Follows::pins_and_cuts;
  study.inputs.set = sets_of_scene(options.study.inputs.set);
  Classified result{study_scene(study), file, {}};
  const Scene& scene = result.scene;
  const Problem problem{scene.world, frame_times(scene.duration, scene.fps), scene.timeline};
  std::optional<Reference> reference;
  if (!options.no_truth) {
    reference = quick_reference(problem, 0.01 * total_length(scene.world),
                                std::max(options.cap, kTruthCap));
  }
  if (reference) result.horizon = reference->horizon;
  for (const Contender& contender : contenders) {
    stop_if_interrupted();
    Classified::Method method{&contender, {}};
    if (contender.method->missing.empty()) {
      method.run = taut::run(problem, candidate_for(contender, scene, options.study.inputs.set),
                             options.cap);
      method.classification = classify(problem, *method.run, reference ? &*reference : nullptr);
      method.run->frames.clear();
    }
    result.methods.push_back(std::move(method));
  }
  return result;
}

std::vector<std::string> row_of(const Classified& one) {
  std::vector<std::string> row{one.scene.title, one.horizon ? rounded(*one.horizon) : "-"};
  for (const Classified::Method& method : one.methods)
    row.push_back(method.run ? words(*method.run, method.classification)
                             : std::string(method.contender->method->missing));
  return row;
}

Json json_of(const Classified& one) {
  Json json = {{"scene", one.file},
               {"title", one.scene.title},
               {"truth_until_s", one.horizon ? Json(*one.horizon) : Json(nullptr)}};
  for (const Classified::Method& method : one.methods) {
    Json entry = {{"method", method.contender->label}};
    if (method.run) {
      const Classification& found = method.classification;
      const bool diverged = method.run->end == Run::End::diverged;
      entry.update({{"verdict", name_of(found.motion_class)},
                    {"energy_gain", number_or_null(found.gain)},
                    {"energy_loss", number_or_null(found.loss)},
                    {"stretch_max", number_or_null(found.stretch)},
                    {"rms_error", number_or_null(found.error)},
                    {"reached_s", method.run->reached},
                    {"diverged_at_s", diverged ? Json(method.run->failed_at) : Json(nullptr)},
                    {"cpu_s", method.run->cpu}});
    } else {
      entry.update({{"verdict", nullptr}, {"missing", method.contender->method->missing}});
    }
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

int run(const Options& options, const Common& common) {
  const std::vector<Contender> contenders = chosen_contenders(options.study);
  for (const std::string& set : options.study.inputs.set) {
    const bool known =
        !sets_of_scene({set}).empty() || std::ranges::any_of(contenders, [&](const Contender& one) {
          return !settings_of(*one.method, {set}).empty();
        });
    if (!known) throw Misuse(fmt::format("--set {}: is no setting of these methods", set));
  }
  Table table{{"scene", "truth until (s)"}, {}};
  for (const Contender& contender : contenders) table.columns.push_back(contender.label);
  Json json = {{"scenes", Json::array()}};
  {
    const std::vector<std::string>& scenes = options.study.inputs.scenes;
    Progress progress("classifying", "scenes", scenes.size(), common.quiet);
    for (const std::string& file : scenes) {
      const Classified one = classified(options, file, contenders);
      table.add(row_of(one));
      json["scenes"].push_back(json_of(one));
      progress.update(table.rows.size());
    }
  }
  if (!options.study.out.empty())
    write_csv(table, std::filesystem::path(options.study.out) / "classify");
  write_output(common.json        ? json.dump(2) + "\n"
               : options.markdown ? to_markdown(table)
                                  : table_text(table));
  return kDone;
}

}  // namespace

void add_classify(CLI::App& app, Program& program) {
  Command command =
      add_command(app, program, "classify", "The class of the motion of each method in each scene",
                  R"(  taut classify scenes/hard/*.toml
  taut classify scenes/hard/whip.toml --methods xpbd,direct
  taut classify scenes/hard/*.toml --markdown --methods impulse,springs,direct
  taut classify scenes/rope_swing.toml --methods springs --set step=0.001 --set stiffness=1e6

The first class that fits: failed (diverged, or gained 10% of the energy), stretched (a link by 1%),
over-damped (lost 10%), accurate (RMS within 1% of the length of truth), plausible. Methods run at
their own settings, or at those of --set that they have; where the scene's step is a whole frame,
they take that.)");
  const auto options = std::make_shared<Options>();
  add_scene_options(command, options->study.inputs);
  command.add_option("--out", options->study.out, "Folder for classify.csv; default: none");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to classify, METHOD or METHOD:FORM, with commas; default: all")
      .delimiter(',');
  command.add_option("--cap", options->cap, "Seconds of CPU time that a run may take; default: 5")
      .positive();
  command.add_flag("--no-truth", options->no_truth,
                   "Solve no truth: accurate motion is called plausible, too");
  command.add_flag("--markdown", options->markdown, "The table as Markdown");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
