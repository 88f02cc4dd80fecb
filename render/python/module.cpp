// import taut: Python's interface to the simulation and its pictures.
#include "render/base/version.h"
#include "render/python/errors.h"
#include "render/python/scene.h"
#include "render/python/simulation.h"
#include "render/python/world.h"
#include "sim/motion/stop.h"

PYBIND11_MODULE(taut, module) {
  using namespace taut::python;
  module.doc() = R"(Simulates ropes, chains and cords, and renders them.

SI units, y up, quaternions w, x, y, z. Everything that is raised derives from taut.Error, but for
what Python itself raises (TypeError, MemoryError, KeyboardInterrupt).)";
  module.attr("__version__") = taut::render::version();
  taut::set_stop_check(look_for_signals_within);
  add_errors(module);
  add_world(module);
  add_simulation(module);
  add_scene(module);
  add_batch(module);
}
