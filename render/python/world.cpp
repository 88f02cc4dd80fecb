#include "render/python/world.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>

namespace taut::python {
namespace {

/// A particle's index; negative ones count from the last.
std::size_t particle_index(const Connector& connector, py::ssize_t particle) {
  const auto count = static_cast<py::ssize_t>(connector.particles());
  if (particle < -count || particle >= count) {
    throw std::invalid_argument(
        fmt::format("particle {}: {} has {} particles", particle, connector.name, count));
  }
  return static_cast<std::size_t>(particle < 0 ? particle + count : particle);
}

template <class Named>
void refuse_second(const std::vector<Named>& all, const std::string& name, const char* kind) {
  if (std::ranges::find(all, name, &Named::name) != all.end()) {
    throw std::invalid_argument(fmt::format("there is a {} \"{}\" already", kind, name));
  }
}

double positive(double value, const char* what) {
  if (!(value > 0 && std::isfinite(value))) {
    throw std::invalid_argument(
        fmt::format("{}: found {}, expected a number above 0", what, value));
  }
  return value;
}

MassProperties mass_properties(double mass, const py::object& cylinder, const py::object& sphere,
                               const py::object& box) {
  positive(mass, "mass");
  if (cylinder.is_none() + sphere.is_none() + box.is_none() != 2) {
    throw std::invalid_argument("expected one of cylinder, sphere and box");
  }
  if (!cylinder.is_none()) {
    const Numbers sizes = numbers(cylinder, "cylinder", 1, 2);
    return solid_cylinder(mass, positive(sizes.data()[0], "length of the cylinder"),
                          positive(sizes.data()[1], "diameter of the cylinder"));
  }
  if (!sphere.is_none())
    return solid_sphere(mass, positive(py::cast<double>(sphere), "diameter of the sphere"));
  const Vec3 size = vec3(box, "box");
  positive(size.minCoeff(), "size of the box");
  return solid_box(mass, size);
}

std::shared_ptr<const Path> path_of(const py::object& times, const py::object& positions,
                                    const py::object& rotations, bool ease) {
  const Numbers t = numbers(times, "times", 1);
  const std::vector<Vec3> at = points(positions, "positions");
  std::optional<Numbers> turned;
  if (!rotations.is_none()) turned = numbers(rotations, "rotations", 2, 4);
  const auto count = static_cast<std::size_t>(t.size());
  if (at.size() != count || (turned && turned->shape(0) != t.size())) {
    throw std::invalid_argument(fmt::format(
        "path: expected as many positions and rotations as times, which are {}", count));
  }
  std::vector<PathKey> keys(count);
  for (std::size_t i = 0; i < count; ++i) {
    keys[i] = {t.data()[i], at[i], Quat::Identity(), ease};
    if (!turned) continue;
    const double* q = turned->data() + 4 * i;
    keys[i].rotation = Quat(q[0], q[1], q[2], q[3]).normalized();
  }
  return std::make_shared<const Path>(std::move(keys));
}

}  // namespace

void WorldObject::add_connector(const std::string& name, const py::object& positions, double mass,
                                const py::object& velocities, double restitution,
                                const std::string& model) {
  refuse_second(world_.connectors, name, "connector");
  Connector made;
  made.name = name;
  made.position = points(positions, "positions");
  if (made.position.size() < 2)
    throw std::invalid_argument("positions: expected at least 2 particles");
  made.mass = positive(mass, "mass");
  made.particle_mass.assign(made.particles(), mass / static_cast<double>(made.particles()));
  made.velocity.assign(made.particles(), Vec3::Zero());
  if (!velocities.is_none()) made.velocity = points(velocities, "velocities");
  if (made.velocity.size() != made.particles()) {
    throw std::invalid_argument(fmt::format("velocities: expected {} rows, found {}",
                                            made.particles(), made.velocity.size()));
  }
  for (std::size_t i = 0; i + 1 < made.particles(); ++i) {
    made.rest.push_back(
        positive((made.position[i + 1] - made.position[i]).norm(), "length of a link"));
    made.length += made.rest.back();
  }
  if (!(restitution >= 0 && restitution <= 1)) {
    throw std::invalid_argument(fmt::format("restitution: found {}, expected 0 to 1", restitution));
  }
  made.restitution = restitution;
  if (model != "links" && model != "span") {
    throw std::invalid_argument(
        fmt::format("model: found \"{}\", expected \"links\" or \"span\"", model));
  }
  if (model == "span") made.model = ConnectorModel::span;
  world_.connectors.push_back(std::move(made));
}

void WorldObject::add_body(Body body) {
  refuse_second(world_.bodies, body.name, "body");
  world_.bodies.push_back(std::move(body));
}

Connector& WorldObject::connector(const std::string& name) {
  return world_.connectors[index_of(world_.connectors, name, "connector")];
}

void WorldObject::add_mass(const std::string& name, py::ssize_t particle, double mass) {
  Connector& on = connector(name);
  on.particle_mass[particle_index(on, particle)] += positive(mass, "mass");
}

void WorldObject::hold(const std::string& name, py::ssize_t particle, const Attachment& to) {
  Connector& held = connector(name);
  const std::size_t index = particle_index(held, particle);
  const auto after = std::ranges::lower_bound(held.holds, index, {}, &Hold::particle);
  if (after != held.holds.end() && after->particle == index) {
    throw std::invalid_argument(fmt::format("particle {} of {} is held already", index, name));
  }
  held.holds.insert(after, {index, to, {}});
}

// The arrays of connectors stay where they are when a connector is added.
py::array WorldObject::positions(const std::string& name) {
  return windows_.open(connector(name).position, shared_from_this(), true);
}

py::array WorldObject::velocities(const std::string& name) {
  return windows_.open(connector(name).velocity, shared_from_this(), true);
}

void add_world(py::module_& module) {
  using namespace py::literals;
  py::class_<Path, std::shared_ptr<Path>>(
      module, "Path", R"(A given motion: smooth (twice continuously differentiable) through keys.

times: (k,) s, rising. positions: (k, 3) m. rotations: (k, 4) quaternions w, x, y, z, or None.
ease: comes to rest at every key. Before the first key and after the last it rests.)")
      .def(py::init([](const py::object& times, const py::object& positions,
                       const py::object& rotations, bool ease) {
             return std::const_pointer_cast<Path>(path_of(times, positions, rotations, ease));
           }),
           "times"_a, "positions"_a, "rotations"_a = py::none(), py::kw_only(), "ease"_a = false)
      .def(
          "position",
          [](const Path& path, double time) {
            const Vec3 at = path.at(time).position;
            return py::array_t<double>(3, at.data());
          },
          "time"_a, "Where it is at `time` (s): (3,) m.");

  py::class_<WorldObject, std::shared_ptr<WorldObject>>(
      module, "World", R"(Connectors and bodies to simulate. SI units, y up.

gravity: (3,) m/s^2. Simulations take a copy of the world; what is changed later does not reach
them.)")
      .def(py::init([](const py::object& gravity) {
             return std::make_shared<WorldObject>(vec3(gravity, "gravity"));
           }),
           "gravity"_a = py::make_tuple(0.0, -9.81, 0.0))
      .def("add_connector", &WorldObject::add_connector, "name"_a, "positions"_a, "mass"_a,
           py::kw_only(), "velocities"_a = py::none(), "restitution"_a = 0.0, "model"_a = "links",
           R"(Adds a rope, chain or cord.

positions: (n, 3) m; links are as long as they are here. mass: kg, shared evenly by the particles.
velocities: (n, 3) m/s, or None: at rest. restitution: 0 to 1, when the span goes taut. model:
"links", or "span" for a massless span.)")
      .def(
          "add_body",
          [](WorldObject& world, const std::string& name, double mass, const py::object& cylinder,
             const py::object& sphere, const py::object& box, const py::object& position,
             const py::object& rotation, const py::object& velocity, const py::object& spin,
             const std::shared_ptr<Path>& path, const py::object& grip) {
            Body body;
            body.name = name;
            body.mass_properties = mass_properties(mass, cylinder, sphere, box);
            body.position = vec3(position, "position");
            body.rotation = quaternion(rotation, "rotation");
            body.velocity = vec3(velocity, "velocity");
            body.spin = vec3(spin, "spin");
            body.path = path;
            body.grip = vec3(grip, "grip");
            world.add_body(std::move(body));
          },
          "name"_a, "mass"_a, py::kw_only(), "cylinder"_a = py::none(), "sphere"_a = py::none(),
          "box"_a = py::none(), "position"_a = py::make_tuple(0.0, 0.0, 0.0),
          "rotation"_a = py::make_tuple(1.0, 0.0, 0.0, 0.0),
          "velocity"_a = py::make_tuple(0.0, 0.0, 0.0), "spin"_a = py::make_tuple(0.0, 0.0, 0.0),
          "path"_a = std::shared_ptr<Path>(), "grip"_a = py::make_tuple(0.0, 0.0, 0.0),
          R"(Adds a rigid body of `mass` (kg) and one shape, centred on its own origin.

cylinder: (length, diameter) m, along y. sphere: diameter, m. box: (3,) m. position: (3,) m of the
origin. rotation: (4,) w, x, y, z. velocity: (3,) m/s. spin: (3,) rad/s, world axes. path: what
carries its point `grip` (m, own frame); without one it is free.)")
      .def("add_mass", &WorldObject::add_mass, "connector"_a, "particle"_a, "mass"_a,
           "Adds a point mass (kg) to a particle; -1 is the last.")
      .def(
          "hold",
          [](WorldObject& world, const std::string& connector, py::ssize_t particle,
             const py::object& point, const std::optional<std::string>& body,
             const std::shared_ptr<Path>& path) {
            auto to = attachment(world.world(), point, body, path);
            if (!to) throw std::invalid_argument("hold: expected a point, a body or a path");
            world.hold(connector, particle, *to);
          },
          "connector"_a, "particle"_a, py::kw_only(), "point"_a = py::none(),
          "body"_a = std::optional<std::string>(), "path"_a = std::shared_ptr<Path>(),
          R"(Holds a particle; -1 is the last.

point: (3,) m in space or, with a body or a path, in its frame (default: its origin).)")
      .def("positions", &WorldObject::positions, "connector"_a,
           "The particles as an array (n, 3) of m that writes into the world. Links keep the "
           "lengths\n"
           "that they were added with.")
      .def("velocities", &WorldObject::velocities, "connector"_a,
           "Their velocities as an array (n, 3) of m/s that writes into the world.")
      .def_property_readonly(
          "connectors", [](const WorldObject& world) { return names(world.world().connectors); },
          "Names of the connectors.")
      .def_property_readonly(
          "bodies", [](const WorldObject& world) { return names(world.world().bodies); },
          "Names of the bodies.");
}

}  // namespace taut::python
