// Scenes as Python loads them.
#pragma once

#include <functional>
#include <memory>

#include "render/python/convert.h"

namespace taut::python {

struct SceneObject {
  scenes::Scene scene;  // without its stage
  std::vector<scenes::SceneChange> changes;
};

void add_scene(py::module_& module);
void add_pictures(py::module_& module, py::class_<SceneObject>& scene);
void add_study(py::module_& module, py::class_<SceneObject>& scene);
void add_batch(py::module_& module);

}  // namespace taut::python
