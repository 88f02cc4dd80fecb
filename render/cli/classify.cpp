// taut classify: the class of the motion of each method in each scene.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/stability_study.h"
#include "render/study/study_target.h"
#include "sim/study/stability.h"

namespace taut::cli {
namespace classify_command {
namespace {

struct Options {
  options::StudyOptions study;  // of its fields only inputs and methods
  double cap = 5;               // s of CPU time
  bool markdown = false, no_truth = false;
};

/// The class, and the number that it was found by.
std::string words(const study::Run& run, const study::Classification& found) {
  switch (found.motion_class) {
    case study::MotionClass::failed:
      return run.end == study::Run::End::diverged
                 ? fmt::format("failed: diverged at {} s", options::rounded(run.failed_at))
                 : "failed: gained " + options::percent(found.gain) + " energy";
    case study::MotionClass::stretched:
      return "stretched " + options::percent(found.stretch);
    case study::MotionClass::over_damped:
      return "over-damped: lost " + options::percent(found.loss);
    case study::MotionClass::over_cap:
      return fmt::format("over the CPU cap at {} s", options::rounded(run.reached));
    case study::MotionClass::accurate:
      return "accurate: " + options::percent(found.error);
    case study::MotionClass::plausible:
      return std::isnan(found.error) ? "plausible"
                                     : "plausible: off by " + options::percent(found.error);
  }
  return "";
}

/// The contender at its defaults. A scene whose step is a whole frame asks every method that has a
/// step to take that.
MethodChoice candidate_for(const options::Contender& contender, const scenes::Scene& scene,
                           const std::vector<std::string>& set) {
  MethodChoice candidate = contender.candidate;
  for (const auto& [name, value] : options::settings_of(*contender.method, set)) {
    candidate.settings[name] = value;
  }
  if (const std::string wrong = complaint(*contender.method, candidate.settings); !wrong.empty()) {
    throw program::Misuse(fmt::format("--set: {}", wrong));
  }
  const auto step = scene.method.settings.find("step");
  if (step == scene.method.settings.end() ||
      number(scene.method.settings, "step") * scene.fps < 0.999) {
    return candidate;
  }
  if (find_setting(*contender.method, "step")) candidate.settings.insert(*step);
  return candidate;
}

/// The class of each contender in a scene.
struct Classified {
  scenes::Scene scene;
  std::string file;
  std::optional<double> horizon;  // s
  struct Method {
    const options::Contender* contender;
    std::string missing;  // why there is no run
    std::optional<study::Run> run;
    study::Classification classification = {};
  };
  std::vector<Method> methods = {};
};

Classified classified(const Options& options, const std::string& file,
                      const std::vector<options::Contender>& contenders) {
  options::StudyOptions study = options.study;
  study.scene = file;
  study.features = options::study_features("classify");
  study.inputs.set = options::sets_of_scene(options.study.inputs.set);
  Classified result{options::study_scene(study), file, {}};
  const scenes::Scene& scene = result.scene;
  const study::Problem problem{scene.world, study::frame_times(scene.duration, scene.fps),
                               scene.timeline};
  std::optional<truth::Reference> reference;
  if (!options.no_truth) {
    reference = studies::quick_reference(problem, 0.01 * study::total_length(scene.world),
                                         std::max(options.cap, studies::kTruthCap));
  }
  if (reference) result.horizon = reference->horizon;
  for (const options::Contender& contender : contenders) {
    render::stop_if_interrupted();
    Classified::Method method{&contender, std::string(contender.method->missing), {}};
    if (method.missing.empty() && !follows(*contender.method, scene.world)) {
      method.missing = "does not follow it";
    }
    if (method.missing.empty()) {
      method.run = study::run(problem, candidate_for(contender, scene, options.study.inputs.set),
                              options.cap);
      method.classification =
          study::classify(problem, *method.run, reference ? &*reference : nullptr);
      method.run->frames.clear();
    }
    result.methods.push_back(std::move(method));
  }
  return result;
}

std::vector<std::string> row_of(const Classified& one) {
  std::vector<std::string> row{one.scene.title, one.horizon ? options::rounded(*one.horizon) : "-"};
  for (const Classified::Method& method : one.methods)
    row.push_back(method.run ? words(*method.run, method.classification) : method.missing);
  return row;
}

program::Json json_of(const Classified& one) {
  program::Json json = {
      {"scene", one.file},
      {"title", one.scene.title},
      {"truth_until_s", one.horizon ? program::Json(*one.horizon) : program::Json(nullptr)}};
  for (const Classified::Method& method : one.methods) {
    program::Json entry = {{"method", method.contender->label}};
    if (method.run) {
      const study::Classification& found = method.classification;
      const bool diverged = method.run->end == study::Run::End::diverged;
      entry.update({{"class", study::name_of(found.motion_class)},
                    {"energy_gain", program::number_or_null(found.gain)},
                    {"energy_loss", program::number_or_null(found.loss)},
                    {"stretch_max", program::number_or_null(found.stretch)},
                    {"rms_error", program::number_or_null(found.error)},
                    {"reached_s", method.run->reached},
                    {"diverged_at_s",
                     diverged ? program::Json(method.run->failed_at) : program::Json(nullptr)},
                    {"cpu_s", method.run->cpu}});
    } else {
      entry.update({{"class", nullptr}, {"missing", method.missing}});
    }
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

int run(const Options& options, const program::Common& common) {
  const std::vector<options::Contender> contenders = options::chosen_contenders(options.study);
  for (const std::string& set : options.study.inputs.set) {
    const bool known = !options::sets_of_scene({set}).empty() ||
                       std::ranges::any_of(contenders, [&](const options::Contender& one) {
                         return !options::settings_of(*one.method, {set}).empty();
                       });
    if (!known) throw program::Misuse(fmt::format("--set {}: is no setting of these methods", set));
  }
  chart::Table table{{"scene", "truth until (s)"}, {}};
  for (const options::Contender& contender : contenders) table.columns.push_back(contender.label);
  program::Json json = {{"scenes", program::Json::array()}};
  {
    const std::vector<std::string>& scenes = options.study.inputs.scenes;
    options::tell_old_keys(options.study.inputs, common);
    program::Progress progress("classifying", "scenes", scenes.size(), common.quiet);
    for (const std::string& file : scenes) {
      const Classified one = classified(options, file, contenders);
      table.add(row_of(one));
      json["scenes"].push_back(json_of(one));
      progress.update(table.rows.size());
    }
  }
  if (!options.study.out.empty())
    options::write_csv(table, std::filesystem::path(options.study.out) / "classify");
  render::write_output(common.json        ? program::json_text(json) + "\n"
                       : options.markdown ? chart::to_markdown(table)
                                          : program::table_text(table));
  return program::kDone;
}

}  // namespace
}  // namespace classify_command

void add_classify(CLI::App& app, program::Program& program) {
  using namespace classify_command;
  program::Command command =
      program::add_command(app, program, "classify",
                           "Classify the result of each method: accurate, stretched, failed ...",
                           R"(  taut classify scenes/hard/*.toml
  taut classify scenes/hard/whip.toml --methods xpbd,direct
  taut classify scenes/hard/*.toml --markdown --methods impulse,springs,direct
  taut classify scenes/rope_swing.toml --methods springs --set step=0.001 --set stiffness=1e6

The first class that fits: failed (diverged, or gained 10% of the energy), stretched (a link by 1%),
over-damped (lost 10%), accurate (RMS error within 1% of the length), plausible. Methods run at
their default settings, with those of --set that they have; if the scene's step is a whole frame,
they use that step.)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->study.inputs);
  command.add_option("--out", options->study.out, "Folder for classify.csv; default: none");
  command
      .add_option("--methods", options->study.methods,
                  "Methods to classify, METHOD or METHOD:FORM, separated by commas; default: all")
      .delimiter(',');
  command.add_option("--cap", options->cap, "CPU time limit of a run, s; default: 5").positive();
  command.add_flag("--no-truth", options->no_truth,
                   "Do not compute the truth; accurate motion is then classified as plausible");
  command.add_flag("--markdown", options->markdown, "Print the table as Markdown");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
