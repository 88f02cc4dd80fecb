// The truth of a scene, and what methods are off it: a row of the chart.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <stdexcept>

#include "render/python/errors.h"
#include "render/python/scene.h"
#include "sim/evaluation/run.h"
#include "sim/study/speed_accuracy.h"
#include "sim/truth/truth.h"

namespace taut::python {
namespace {

struct TruthObject {
  study::Problem problem;
  truth::Reference reference;
  double length = 0;  // m
  int fps = 60;
};

/// As `taut chart` solves it, `--quick` or not.
std::unique_ptr<TruthObject> solve(const SceneObject& object, bool quick) {
  const scenes::Scene& scene = object.scene;
  if (scene.world.connectors.empty() || !(scene.world.connectors.front().length > 0)) {
    throw std::invalid_argument("the scene has no connector with a length to measure errors by");
  }
  if (!scene.timeline.cuts.empty())
    throw std::invalid_argument("the scene has cuts, which no truth follows");
  auto made = std::make_unique<TruthObject>();
  made->problem = {scene.world, study::frame_times(scene.duration, scene.fps), scene.timeline};
  made->length = scene.world.connectors.front().length;
  truth::TruthOptions options;
  options.scored_error = made->length * (quick ? 1e-4 : 1e-6);
  if (quick) options.second_accuracy = 1e-7;
  const py::gil_scoped_release unlocked;
  made->reference = truth::solve_truth(scene.world, made->problem.times, options, scene.timeline,
                                       look_for_signals);
  std::erase_if(made->problem.times, [&](double time) { return time > made->reference.horizon; });
  made->reference.frames.resize(made->problem.times.size());
  if (made->problem.times.size() < 2) {
    throw std::runtime_error(
        fmt::format("{}: nothing is predictable: the horizon of the truth is {} s",
                    scene.file.string(), made->reference.horizon));
  }
  return made;
}

study::AccuracyRow score_one(const TruthObject& truth, const std::string& method, double cap,
                             const py::kwargs& keywords) {
  const Settings settings = settings_of(keywords);
  made_method(truth.problem.world, {method, settings});  // throws where it cannot be
  const study::Metric metric = study::share_of_length(truth.length);
  const py::gil_scoped_release unlocked;
  return study::score(truth.problem, truth.reference, {&metric, 1}, {method, settings}, cap,
                      look_for_signals);
}

py::dict methods() {
  py::dict all;
  for (const MethodInfo& method : all_methods()) {
    if (method.missing.empty()) {
      all[std::string(method.name).c_str()] = to_dict(with_defaults(method, {}));
    }
  }
  return all;
}

std::vector<py::dict> swept(const std::string& name, bool quick) {
  const MethodInfo* method = find_method(name);
  if (!method) throw std::invalid_argument(method_complaint(name));
  std::vector<py::dict> all;
  for (const MethodChoice& candidate : study::sweep(*method, quick))
    all.push_back(to_dict(candidate.settings));
  return all;
}

}  // namespace

void add_study(py::module_& module, py::class_<SceneObject>& scene) {
  using namespace py::literals;
  module.def("methods", methods,
             "The methods of this build, each with its settings at their defaults.");
  module.def("sweep", swept, "method"_a, "quick"_a = false,
             "The settings that `taut chart` (`--quick`) goes through, in its order.");

  py::class_<study::AccuracyRow>(module, "Score", "A row of the chart of speed against accuracy.")
      .def_property_readonly(
          "method", [](const study::AccuracyRow& row) { return row.candidate.name; },
          "The method's name.")
      .def_property_readonly(
          "settings", [](const study::AccuracyRow& row) { return to_dict(row.candidate.settings); },
          "As they were given.")
      .def_property_readonly(
          "label", [](const study::AccuracyRow& row) { return describe(row.candidate.settings); },
          "The settings as chart.csv has them.")
      .def_property_readonly(
          "outcome", [](const study::AccuracyRow& row) { return study::text_of(row.end); },
          "\"done\", \"diverged\" or \"over its CPU cap\".")
      .def_readonly("reason", &study::AccuracyRow::reason, "Why, where it is not done.")
      .def_property_readonly(
          "error", [](const study::AccuracyRow& row) { return row.errors.front(); },
          "RMS of the distance of all particles from the truth, over all frames up to the\n"
          "horizon, as a share of the first connector's length; infinite unless done.")
      .def_property_readonly(
          "cpu",
          [](const study::AccuracyRow& row) { return row.cpu.empty() ? NAN : row.cpu.front(); },
          "s of CPU time per simulated second; nan unless done.")
      .def_readonly("steps", &study::AccuracyRow::steps, "Per simulated second.")
      .def_readonly("solves", &study::AccuracyRow::solves, "Per simulated second.")
      .def_readonly("stretch", &study::AccuracyRow::stretch_max,
                    "The largest |length / rest length - 1| of any link.");

  py::class_<TruthObject>(module, "Truth",
                          R"(The converged solution of a scene, see Scene.truth().)")
      .def("score", score_one, "method"_a, py::kw_only(), "cap"_a = 60.0,
           R"(Runs a method up to the horizon and scores it; settings are keywords.

cap: s of CPU time after which the run ends. A method that diverges has a score, too. Raises
ArgumentError.)")
      .def_property_readonly(
          "horizon", [](const TruthObject& truth) { return truth.reference.horizon; },
          "s up to which the motion is predictable.")
      .def_property_readonly(
          "self_error", [](const TruthObject& truth) { return truth.reference.self_error; },
          "m by which two independent solvers differ until then.")
      .def_readonly("length", &TruthObject::length, "m of the first connector.");
  scene.def(
      "truth", solve, py::kw_only(), "quick"_a = false,
      R"(Solves the scene by two independent solvers, as `taut chart` (`--quick`) does; takes seconds to minutes.

Raises ArgumentError where the scene has cuts or no connector with a length, and Error where nothing
is predictable. Ctrl-C ends it between two frames.)");
}

}  // namespace taut::python
