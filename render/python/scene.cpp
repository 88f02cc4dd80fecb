#include "render/python/scene.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <stdexcept>

#include "render/python/errors.h"
#include "render/python/simulation.h"
#include "scenes/files/files.h"
#include "scenes/load/faults.h"
#include "scenes/load/load_scene.h"

namespace taut::python {
namespace {

std::string to_toml(const py::handle& value);

std::string list_to_toml(const py::handle& list) {
  std::string text;
  for (const py::handle element : list) text += (text.empty() ? "" : ", ") + to_toml(element);
  return "[" + text + "]";
}

std::string quoted(const py::handle& text) {
  return py::cast<std::string>(py::module_::import("json").attr("dumps")(text));
}

/// A value as TOML writes it.
std::string to_toml(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return py::cast<bool>(value) ? "true" : "false";
  if (py::isinstance<py::str>(value)) return quoted(value);
  if (py::isinstance<py::int_>(value)) return py::str(value);
  if (py::isinstance<py::float_>(value)) return fmt::format("{:.17e}", py::cast<double>(value));
  if (py::isinstance<py::dict>(value)) {
    std::string text;
    for (const auto& [key, member] : py::reinterpret_borrow<py::dict>(value)) {
      text +=
          fmt::format("{}{} = {}", text.empty() ? "" : ", ", quoted(py::str(key)), to_toml(member));
    }
    return "{" + text + "}";
  }
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
    return list_to_toml(value);
  if (py::hasattr(value, "tolist")) return to_toml(value.attr("tolist")());  // numpy's
  throw std::invalid_argument(
      fmt::format("set: {} is no value of a scene", std::string(py::repr(value))));
}

std::vector<scenes::SceneChange> changes_of(const py::dict& set) {
  std::vector<scenes::SceneChange> changes;
  for (const auto& [key, value] : set) changes.push_back({py::str(key), to_toml(value)});
  return changes;
}

std::unique_ptr<SceneObject> load(const std::filesystem::path& file, const py::dict& set) {
  auto object = std::make_unique<SceneObject>();
  object->changes = changes_of(set);
  const py::gil_scoped_release unlocked;
  object->scene = scenes::load_scene(file, false, object->changes);
  return object;
}

std::shared_ptr<SimulationObject> start_simulation(const SceneObject& object,
                                                   const std::string& method,
                                                   const py::kwargs& settings) {
  scenes::Scene scene = object.scene;
  scene.method = chosen_method(scene, method, settings_of(settings));
  made_method(scene.world, scene.method);  // or it throws
  {
    const py::gil_scoped_release unlocked;
    scenes::settle_breaks(scene);
  }
  return std::make_shared<SimulationObject>(scene.world, scene.method, scene.timeline, scene.fps);
}

/// Frames of a scene, and memory for them.
struct Trajectory {
  std::string method;
  py::array_t<double> times;  // (frames,)
  py::dict positions;         // name: (frames, n, 3)
  py::dict poses;             // name: (frames, 7)
  std::vector<double*> rows;  // of the connectors, then of the bodies

  Trajectory(const scenes::Scene& scene, std::string by)
      : method(std::move(by)), times(scene.frames()) {
    const World world = divided(scene.world, scene.timeline);
    const py::ssize_t frames = scene.frames();
    const auto add = [&](py::dict& to, const std::string& name, std::vector<py::ssize_t> shape) {
      py::array_t<double> array(std::move(shape));
      rows.push_back(array.mutable_data());
      to[name.c_str()] = array;
    };
    for (const Connector& connector : world.connectors)
      add(positions, connector.name, {frames, py::ssize_t(connector.particles()), 3});
    for (const Body& body : world.bodies) add(poses, body.name, {frames, 7});
  }

  void put(const Snapshot& state) {
    auto row = rows.begin();
    for (const std::vector<Vec3>& particles : state.connectors) {
      for (const Vec3& particle : particles) *row = std::ranges::copy(particle, *row).out;
      ++row;
    }
    for (const Pose& frame : state.bodies) {
      *row = std::ranges::copy(frame.position, *row).out;
      const Quat& q = frame.rotation;
      for (const double part : {q.w(), q.x(), q.y(), q.z()}) *(*row)++ = part;
      ++row;
    }
  }
};

Trajectory simulate(const SceneObject& object, const std::string& method,
                    const py::kwargs& settings) {
  scenes::Scene scene = object.scene;
  const MethodChoice choice = chosen_method(scene, method, settings_of(settings));
  scene.method = choice;
  made_method(scene.world, choice);  // or it throws
  {
    const py::gil_scoped_release unlocked;
    scenes::settle_breaks(scene);
  }
  Simulation simulation(scene.world, made_method(scene.world, choice), scene.timeline);
  Trajectory made(scene, choice.name);
  double* times = made.times.mutable_data();
  const py::gil_scoped_release unlocked;
  for (int frame = 0; frame < scene.frames(); ++frame) {
    look_for_signals();
    simulation.advance_to(static_cast<double>(frame) / scene.fps);
    *times++ = simulation.world().time;
    made.put(simulation.state());
  }
  return made;
}

}  // namespace

void add_scene(py::module_& module) {
  using namespace py::literals;
  module.def(
      "set_asset_folder",
      [](const std::filesystem::path& folder) { scenes::set_asset_folder(folder); }, "folder"_a,
      "The folder in which the files that scenes name are looked for first, from now on.");
  py::class_<Trajectory>(module, "Trajectory", "The frames of a scene.")
      .def_readonly("method", &Trajectory::method, "The method's name.")
      .def_readonly("times", &Trajectory::times, "(frames,) s: frame k is at k / fps.")
      .def_readonly(
          "positions", &Trajectory::positions,
          "For each connector's name an array (frames, n, 3) of m. Particles that pins add are\n"
          "left out; what is cut off a connector has its own from the start.")
      .def_readonly(
          "poses", &Trajectory::poses,
          "For each body's name an array (frames, 7): x, y, z (m), qw, qx, qy, qz of its own\n"
          "frame.");

  py::class_<SceneObject> scene(module, "Scene", "A scene that was read from a file, see load().");
  scene
      .def("simulation", start_simulation, "method"_a = "",
           R"(The scene at its start, to be stepped, with the pins and cuts of its own.

method: another one than the scene's, at its own settings; settings are keywords. Raises
ArgumentError.)")
      .def("simulate", simulate, "method"_a = "",
           R"(The whole scene as a Trajectory: the numbers that `taut simulate` writes, bit for bit.

method: another one than the scene's, at its own settings; settings are keywords. Raises
ArgumentError, DivergedError and InterventionError. Python's lock is free meanwhile; Ctrl-C ends it
between two frames.)")
      .def_property_readonly(
          "file", [](const SceneObject& s) { return s.scene.file.string(); },
          "As load() was given it.")
      .def_property_readonly(
          "title", [](const SceneObject& s) { return s.scene.title; },
          "The title, or the file's name.")
      .def_property_readonly(
          "duration", [](const SceneObject& s) { return s.scene.duration; }, "s")
      .def_property_readonly(
          "fps", [](const SceneObject& s) { return s.scene.fps; }, "Frames per second.")
      .def_property_readonly(
          "frames", [](const SceneObject& s) { return s.scene.frames(); }, "How many.")
      .def_property_readonly(
          "size",
          [](const SceneObject& s) { return py::make_tuple(s.scene.width, s.scene.height); },
          "(width, height) of its pictures.")
      .def_property_readonly(
          "method", [](const SceneObject& s) { return s.scene.method.name; }, "The method's name.")
      .def_property_readonly(
          "settings", [](const SceneObject& s) { return to_dict(s.scene.method.settings); },
          "The settings of the method that the scene names.")
      .def_property_readonly(
          "connectors", [](const SceneObject& s) { return names(s.scene.world.connectors); },
          "Names of the connectors.")
      .def_property_readonly(
          "bodies", [](const SceneObject& s) { return names(s.scene.world.bodies); },
          "Names of the bodies.");
  module.def("load", load, "file"_a, "set"_a = py::dict(),
             R"(Reads a scene file. Raises SceneError and AssetError.

set: values in place of the scene's by their dotted keys: {"connectors.rope.length": 0.5}.)");
  module.def(
      "faults",
      [](const std::filesystem::path& file, const py::dict& set) {
        py::list all;
        for (const scenes::SceneFault& fault : scenes::faults_of(file, changes_of(set)).first)
          all.append(scene_error(fault));
        return all;
      },
      "file"_a, "set"_a = py::dict(),
      "What is wrong with a scene file, a SceneError each, in the order of the file: the first "
      "100.");
  add_pictures(module, scene);
  add_study(module, scene);
}

}  // namespace taut::python
