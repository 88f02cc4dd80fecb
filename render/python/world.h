// Worlds that are built in Python.
#pragma once

#include <memory>

#include "render/python/convert.h"

namespace taut::python {

/// A world to be built and simulated; simulations take a copy.
class WorldObject : public std::enable_shared_from_this<WorldObject> {
 public:
  explicit WorldObject(const Vec3& gravity) { world_.gravity = gravity; }

  void add_connector(Connector made);
  void add_body(Body body);
  void add_obstacle(Obstacle obstacle, const std::vector<std::string>& ignores);
  void add_mass(const std::string& connector, py::ssize_t particle, double mass);
  void hold(const std::string& connector, py::ssize_t particle, const Hold& held);
  void join(const std::string& connector, py::ssize_t particle, const std::string& other,
            py::ssize_t other_particle);
  void add_winch(const std::string& connector, std::shared_ptr<const Path> first,
                 std::shared_ptr<const Path> last);
  void add_pulley(const Pulley& pulley);
  void set_air(const Air& air) { world_.air = air; }
  void add_force(const std::string& connector, const py::function& force);
  /// Names of one kind touch each other; connectors touch bodies.
  void add_touching(const std::vector<std::string>& bodies,
                    const std::vector<std::string>& connectors, const BodyPair& surfaces);
  void add_self_contact(const std::string& connector, const BodyPair& surfaces);

  /// Windows on the particles, for setting out.
  py::array positions(const std::string& connector);
  py::array velocities(const std::string& connector);

  const World& world() const { return world_; }

 private:
  Connector& connector(const std::string& name);
  std::uint64_t category(const std::string& name);

  World world_;
  std::vector<std::string> ignored_;  // each has a category of its own
  Windows windows_;
};

void add_world(py::module_& module);

}  // namespace taut::python
