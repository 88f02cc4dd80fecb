// Worlds that are built in Python.
#pragma once

#include <memory>

#include "render/python/convert.h"
#include "render/python/windows.h"

namespace taut::python {

/// A world to be built and simulated; simulations take a copy.
class WorldObject : public std::enable_shared_from_this<WorldObject> {
 public:
  explicit WorldObject(const Vec3& gravity) { world_.gravity = gravity; }

  void add_connector(const std::string& name, const py::object& positions, double mass,
                     const py::object& velocities, double restitution, const std::string& model);
  void add_body(Body body);
  void add_mass(const std::string& connector, py::ssize_t particle, double mass);
  void hold(const std::string& connector, py::ssize_t particle, const Attachment& to);

  /// Windows on the particles, for setting out.
  py::array positions(const std::string& connector);
  py::array velocities(const std::string& connector);

  const World& world() const { return world_; }

 private:
  Connector& connector(const std::string& name);
  py::array show(std::vector<Vec3>& vectors);

  World world_;
  Windows windows_;
};

void add_world(py::module_& module);

}  // namespace taut::python
