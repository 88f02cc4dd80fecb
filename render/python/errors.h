// The exceptions of the module, and which of taut's become which.
#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>
#include <string>

#include "scenes/files/error.h"
#include "sim/motion/printable.h"

namespace taut::python {

/// A pin, move, release or cut that changed nothing; becomes taut.InterventionError.
class Refused : public std::runtime_error {
 public:
  Refused(const std::string& message, double at)
      : std::runtime_error(printable(message)), time(at) {}
  double time;  // s
};

/// Adds taut.Error and those derived from it.
void add_errors(pybind11::module_& module);

/// An instance of taut.SceneError.
pybind11::object scene_error(const scenes::BadScene& error);

}  // namespace taut::python
