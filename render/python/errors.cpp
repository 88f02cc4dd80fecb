#include "render/python/errors.h"

#include <filesystem>
#include <map>
#include <string>

#include "render/base/error.h"
#include "scenes/files/error.h"
#include "sim/interventions/interventions.h"
#include "sim/run/method.h"

namespace taut::python {
namespace {

namespace py = pybind11;

/// The types live as long as the interpreter.
struct Types {
  PyObject *error, *argument, *scene, *asset, *diverged, *intervention, *context;
};
Types types;

PyObject* add(py::module_& module, const char* name, const py::tuple& bases, const char* doc) {
  const std::string full = std::string("taut.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

py::object instance(PyObject* type, const char* message) {
  return py::reinterpret_borrow<py::object>(type)(message);
}

void raise(PyObject* type, const py::object& error) {
  PyErr_SetObject(type, error.ptr());
}

void raise(PyObject* type, const char* message) {
  raise(type, instance(type, message));
}

void raise_refused(const char* message, double time) {
  py::object value = instance(types.intervention, message);
  value.attr("time") = time;
  raise(types.intervention, value);
}

/// Exceptions that derive from another come before it.
void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const scenes::BadScene& error) {
    raise(types.scene, scene_error(error));
  } catch (const scenes::BadAsset& error) {
    raise(types.asset, error.what());
  } catch (const Diverged& error) {
    py::object value = instance(types.diverged, error.what());
    value.attr("method") = error.method;
    value.attr("time") = error.time;
    value.attr("step") = error.step;
    value.attr("connector") = error.connector;
    value.attr("link") = error.link;
    raise(types.diverged, value);
  } catch (const BadIntervention& error) {
    raise_refused(error.what(), error.time);
  } catch (const Refused& error) {
    raise_refused(error.what(), error.time);
  } catch (const render::NoContext& error) {
    raise(types.context, error.what());
  } catch (const std::invalid_argument& error) {
    raise(types.argument, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    raise(types.error, error.what());
  } catch (const std::system_error& error) {
    raise(types.error, error.what());
  } catch (const std::runtime_error& error) {
    raise(types.error, error.what());
  }
}

}  // namespace

py::object scene_error(const scenes::BadScene& error) {
  py::object value = instance(types.scene, error.what());
  const auto* fault = dynamic_cast<const scenes::SceneFault*>(&error);
  const scenes::FaultPlace place = fault ? fault->place : scenes::FaultPlace{};
  value.attr("file") = place.file;
  value.attr("line") = place.line;
  value.attr("column") = place.column;
  value.attr("key") = place.key;
  return value;
}

void add_errors(py::module_& module) {
  const py::object base = py::reinterpret_borrow<py::object>(PyExc_Exception);
  types.error =
      add(module, "Error", py::make_tuple(base), "What taut raises; the others derive from it.");
  const py::object error = py::reinterpret_borrow<py::object>(types.error);
  const py::tuple alone = py::make_tuple(error);
  types.argument = add(module, "ArgumentError",
                       py::make_tuple(error, py::reinterpret_borrow<py::object>(PyExc_ValueError)),
                       "An argument that cannot be: says what was found and what was expected.");
  types.scene = add(module, "SceneError", alone,
                    "A scene file that cannot be read. `file`, `line` and `column` (from 1; 0: no\n"
                    "place in a file), `key` (dotted) say where.");
  types.asset = add(module, "AssetError", alone,
                    "A model or a data file that cannot be used; the message names it.");
  types.diverged =
      add(module, "DivergedError", alone,
          "A simulation that cannot go on: `method`, `time` (s), `step` (counted from\n"
          "the start), `connector` and `link` say where.");
  types.intervention = add(module, "InterventionError", alone,
                           "A pin, release or cut that is not possible; it has changed nothing.\n"
                           "`time` (s) says when.");
  types.context =
      add(module, "ContextError", alone, "No OpenGL context of the kind that pictures need.");
  py::register_exception_translator(translate);
}

}  // namespace taut::python
