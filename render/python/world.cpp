#include "render/python/world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "sim/material/sections.h"
#include "sim/world/winched.h"

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

/// Rows of a time and a number, as the x of a path.
std::shared_ptr<const Path> number_path(const py::object& rows, const std::string& what) {
  const Numbers found = numbers(rows, what.c_str(), 2, 2);
  std::vector<PathKey> keys;
  for (py::ssize_t i = 0; i < found.shape(0); ++i) {
    keys.push_back({found.data()[2 * i], Vec3(found.data()[2 * i + 1], 0, 0)});
  }
  return std::make_shared<const Path>(std::move(keys));
}

/// Of a winch: nothing is paid out at the start.
std::shared_ptr<const Path> paid_out(const py::object& rows, const char* what) {
  if (rows.is_none()) return nullptr;
  auto path = number_path(rows, what);
  constexpr double kNone = 1e-9;
  const FrameMotion start = path->at(0);
  for (const auto& [value, unit] :
       {std::pair(start.position.x(), "m"), std::pair(start.velocity.x(), "m/s")}) {
    if (std::abs(value) > kNone) {
      throw std::invalid_argument(
          fmt::format("{}: found {} {} at the start, expected 0", what, value, unit));
    }
  }
  return path;
}

double not_negative(double value, const char* what) {
  if (!(value >= 0 && std::isfinite(value))) {
    throw std::invalid_argument(fmt::format("{}: found {}, expected 0 or more", what, value));
  }
  return value;
}

double share(double value, const char* what) {
  if (!(value >= 0 && value <= 1)) {
    throw std::invalid_argument(fmt::format("{}: found {}, expected 0 to 1", what, value));
  }
  return value;
}

bool chosen(const std::string& value, const char* what, const char* usual, const char* other) {
  if (value != usual && value != other) {
    throw std::invalid_argument(
        fmt::format("{}: found \"{}\", expected \"{}\" or \"{}\"", what, value, usual, other));
  }
  return value == other;
}

/// A member of a dictionary, which may have these alone.
class Members {
 public:
  Members(const py::dict& dict, const char* what, std::initializer_list<const char*> known)
      : dict_(dict), what_(what) {
    for (const auto& [key, value] : dict) {
      const auto name = py::cast<std::string>(py::str(key));
      if (std::ranges::find(known, name) != known.end()) continue;
      throw std::invalid_argument(
          fmt::format("{}: found {}, expected one of: {}", what, name, fmt::join(known, ", ")));
    }
  }
  bool has(const char* name) const { return dict_.contains(name); }
  double number(const char* name) const { return py::cast<double>(value(name)); }
  double number(const char* name, double fallback) const {
    return has(name) ? number(name) : fallback;
  }
  py::object value(const char* name) const {
    if (!has(name)) throw std::invalid_argument(fmt::format("{}: {} is missing", what_, name));
    return dict_[name];
  }

 private:
  const py::dict& dict_;
  const char* what_;
};

material::RoundRod rod_of(const py::dict& material) {
  const Members given(material, "material",
                      {"youngs_modulus", "diameter", "density", "poissons_ratio"});
  material::RoundRod rod{
      .youngs_modulus = positive(given.number("youngs_modulus"), "material: youngs_modulus"),
      .diameter = positive(given.number("diameter"), "material: diameter"),
      .density = positive(given.number("density"), "material: density")};
  rod.poissons_ratio = given.number("poissons_ratio", rod.poissons_ratio);
  if (!(rod.poissons_ratio > -1 && rod.poissons_ratio <= 0.5)) {
    throw std::invalid_argument(fmt::format(
        "material: poissons_ratio: found {}, expected above -1 to 0.5", rod.poissons_ratio));
  }
  return rod;
}

BodyPair surfaces(double friction, const std::optional<double>& static_friction,
                  double restitution) {
  BodyPair made;
  made.kinetic_friction = not_negative(friction, "friction");
  made.static_friction = static_friction.value_or(friction);
  if (!(made.static_friction >= friction && std::isfinite(made.static_friction))) {
    throw std::invalid_argument(
        fmt::format("static_friction: found {}, expected at least friction, {}",
                    made.static_friction, friction));
  }
  made.restitution = share(restitution, "restitution");
  return made;
}

struct Laid {
  py::object positions, mass, velocities;
  double restitution;
  std::string model, links, contact;
  double radius, breaks_at;
};

Connector laid(const std::string& name, const Laid& given, const py::dict& material) {
  Connector made;
  made.name = name;
  made.position = points(given.positions, "positions");
  if (made.position.size() < 2)
    throw std::invalid_argument("positions: expected at least 2 particles");
  for (std::size_t i = 0; i + 1 < made.particles(); ++i) {
    made.rest.push_back(
        positive((made.position[i + 1] - made.position[i]).norm(), "length of a link"));
    made.length += made.rest.back();
  }
  const bool is_rod = !material.empty();
  if (is_rod != given.mass.is_none()) {
    throw std::invalid_argument("expected one of mass and material");
  }
  made.mass =
      positive(is_rod ? rod_of(material).mass(made.length) : py::cast<double>(given.mass), "mass");
  made.particle_mass.assign(made.particles(), made.mass / static_cast<double>(made.particles()));
  made.velocity.assign(made.particles(), Vec3::Zero());
  if (!given.velocities.is_none()) made.velocity = points(given.velocities, "velocities");
  if (made.velocity.size() != made.particles()) {
    throw std::invalid_argument(fmt::format("velocities: expected {} rows, found {}",
                                            made.particles(), made.velocity.size()));
  }
  made.restitution = share(given.restitution, "restitution");
  if (chosen(given.model, "model", "links", "span")) made.model = ConnectorModel::span;
  made.pulls = chosen(given.links, "links", "rigid", "pull");
  made.links_touch = chosen(given.contact, "contact", "beads", "links");
  made.radius = not_negative(given.radius, "radius");
  if (!(given.breaks_at > 0)) {
    throw std::invalid_argument(
        fmt::format("breaks_at: found {}, expected a number above 0", given.breaks_at));
  }
  made.breaks_at = given.breaks_at;
  return made;
}

struct Stiff {
  std::optional<double> axial_stiffness, bending_stiffness, twisting_stiffness;
  double axial_damping, bending_damping, twisting_damping;
  py::object rest_curvature;
  double rest_twist;
  std::optional<double> diameter;
  py::object taper;
  py::dict material, drag;
};

/// What a connector resists, as the keys of a scene's connector say it.
void give_sections(const Stiff& given, Connector& to) {
  const bool is_rod = !given.material.empty();
  const auto needs = [&](bool has, const char* what, bool found, const char* other) {
    if (!has || found || is_rod) return;
    throw std::invalid_argument(fmt::format("{}: needs {} or material", what, other));
  };
  const auto one_of = [&](const std::optional<double>& value, const char* what) {
    if (value && is_rod) {
      throw std::invalid_argument(fmt::format("expected one of {} and material", what));
    }
    if (value) positive(*value, what);
  };
  one_of(given.axial_stiffness, "axial_stiffness");
  one_of(given.bending_stiffness, "bending_stiffness");
  one_of(given.twisting_stiffness, "twisting_stiffness");
  const Vec3 curvature = vec3(given.rest_curvature, "rest_curvature");
  const bool stretches = given.axial_stiffness.has_value();
  const bool bends = given.bending_stiffness.has_value();
  const bool twists = given.twisting_stiffness.has_value();
  needs(given.axial_damping > 0, "axial_damping", stretches, "axial_stiffness");
  needs(!curvature.isZero(0), "rest_curvature", bends, "bending_stiffness");
  needs(twists, "twisting_stiffness", bends, "bending_stiffness");
  needs(given.twisting_damping > 0, "twisting_damping", twists, "twisting_stiffness");
  needs(given.rest_twist != 0, "rest_twist", twists, "twisting_stiffness");
  std::vector<double> taper;
  if (!given.taper.is_none()) {
    const Numbers shares = numbers(given.taper, "taper", 1);
    if (shares.size() < 2) throw std::invalid_argument("taper: expected at least 2 numbers");
    for (py::ssize_t i = 0; i < shares.size(); ++i) {
      taper.push_back(positive(shares.data()[i], "taper"));
    }
  }
  const bool any = stretches || bends || is_rod || !taper.empty() || !given.drag.empty() ||
                   given.bending_damping > 0;
  if (!any) return;
  if (to.model == ConnectorModel::span) {
    throw std::invalid_argument("model: found \"span\", which has no stiffness, taper and drag");
  }
  Section section;
  section.axial_stiffness = given.axial_stiffness.value_or(section.axial_stiffness);
  section.axial_damping = not_negative(given.axial_damping, "axial_damping");
  section.bending_stiffness = given.bending_stiffness.value_or(0);
  section.bending_damping = not_negative(given.bending_damping, "bending_damping");
  section.rest_curvature = curvature;
  section.twisting_stiffness = given.twisting_stiffness.value_or(0);
  section.twisting_damping = not_negative(given.twisting_damping, "twisting_damping");
  section.rest_twist = given.rest_twist;
  section.diameter = given.diameter ? positive(*given.diameter, "diameter") : 2 * to.radius;
  if (is_rod) section = rod_of(given.material).section(section);
  material::give_sections(to, section, taper);
  if (is_rod || !taper.empty()) material::weigh_by_links(to, taper);
  const Members drag(given.drag, "drag", {"across", "along"});
  to.drag = {not_negative(drag.number("across", 0), "drag: across"),
             not_negative(drag.number("along", 0), "drag: along")};
}

double diameter_of(const py::object& sphere) {
  return positive(py::cast<double>(sphere), "diameter of the sphere");
}

Shape surface(bool plane, const py::object& sphere, const py::object& capsule,
              const py::object& cylinder, const py::object& box, double rounding) {
  const int found = (plane ? 1 : 0) + (sphere.is_none() ? 0 : 1) + (capsule.is_none() ? 0 : 1) +
                    (cylinder.is_none() ? 0 : 1) + (box.is_none() ? 0 : 1);
  if (found != 1) {
    throw std::invalid_argument("expected one of plane, sphere, capsule, cylinder and box");
  }
  not_negative(rounding, "rounding");
  const auto within = [&](double least) {
    if (rounding > least / 2) {
      throw std::invalid_argument(
          fmt::format("rounding: found {}, expected at most half of its smallest size, {}",
                      rounding, least / 2));
    }
  };
  if (plane) return plane_shape();
  if (!sphere.is_none()) return sphere_shape(diameter_of(sphere) / 2);
  if (!box.is_none()) {
    const Vec3 size = vec3(box, "box");
    within(positive(size.minCoeff(), "size of the box"));
    return box_shape(size, rounding);
  }
  const bool round = !capsule.is_none();
  const Numbers sizes =
      round ? numbers(capsule, "capsule", 1, 2) : numbers(cylinder, "cylinder", 1, 2);
  const double length = positive(sizes.data()[0], "length");
  const double diameter = positive(sizes.data()[1], "diameter");
  if (round) return capsule_shape(diameter / 2, length);
  within(std::min(length, diameter));
  return cylinder_shape(diameter / 2, length, rounding);
}

/// As which a free body touches: by default a cylinder's capsule, or the ball itself.
BodyCapsule body_capsule(const py::dict& contact, const py::object& cylinder,
                         const py::object& sphere) {
  const Members given(contact, "contact", {"radius", "from", "to"});
  BodyCapsule made;
  const Numbers sizes = cylinder.is_none() ? Numbers() : numbers(cylinder, "cylinder", 1, 2);
  if (given.has("radius")) {
    made.radius = positive(given.number("radius"), "contact: radius");
  } else if (!cylinder.is_none()) {
    made.radius = sizes.data()[1] / 2;
  } else if (!sphere.is_none()) {
    made.radius = diameter_of(sphere) / 2;
  } else {
    throw std::invalid_argument("contact: radius is missing");
  }
  if (given.has("from") || given.has("to")) {
    made.from = vec3(given.value("from"), "contact: from");
    made.to = vec3(given.value("to"), "contact: to");
  } else if (!cylinder.is_none()) {
    const double half = sizes.data()[0] / 2 - made.radius;
    if (half < 0) {
      throw std::invalid_argument(
          fmt::format("contact: from and to are missing, which a cylinder shorter than {} m gives "
                      "no line",
                      2 * made.radius));
    }
    made.from = -half * Vec3::UnitY();
    made.to = half * Vec3::UnitY();
  } else if (sphere.is_none()) {
    throw std::invalid_argument("contact: from and to are missing");
  }
  return made;
}

}  // namespace

void WorldObject::add_connector(Connector made) {
  refuse_second(world_.connectors, made.name, "connector");
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

void WorldObject::hold(const std::string& name, py::ssize_t particle, const Hold& held) {
  Connector& on = connector(name);
  Hold made = held;
  made.particle = particle_index(on, particle);
  const auto after = std::ranges::lower_bound(on.holds, made.particle, {}, &Hold::particle);
  if (after != on.holds.end() && after->particle == made.particle) {
    throw std::invalid_argument(
        fmt::format("particle {} of {} is held already", made.particle, name));
  }
  on.holds.insert(after, made);
}

void WorldObject::join(const std::string& name, py::ssize_t particle, const std::string& other,
                       py::ssize_t other_particle) {
  const Joint::Particle one{index_of(world_.connectors, name, "connector"),
                            particle_index(connector(name), particle)};
  const Joint::Particle second{index_of(world_.connectors, other, "connector"),
                               particle_index(connector(other), other_particle)};
  const auto joint_of = [&](const Joint::Particle& at) {
    return std::ranges::find_if(world_.joints, [&](const Joint& joint) {
      return std::ranges::any_of(joint.particles, [&](const Joint::Particle& of) {
        return of.connector == at.connector && of.particle == at.particle;
      });
    });
  };
  const auto first = joint_of(one), last = joint_of(second);
  if (first != world_.joints.end() && first == last) {
    throw std::invalid_argument("join: they are joined already");
  }
  if (first != world_.joints.end() && last != world_.joints.end()) {
    first->particles.insert(first->particles.end(), last->particles.begin(), last->particles.end());
    world_.joints.erase(last);
  } else if (first != world_.joints.end()) {
    first->particles.push_back(second);
  } else if (last != world_.joints.end()) {
    last->particles.push_back(one);
  } else {
    world_.joints.push_back({{one, second}});
  }
}

void WorldObject::add_winch(const std::string& name, std::shared_ptr<const Path> first,
                            std::shared_ptr<const Path> last) {
  Connector& reeled = connector(name);
  if (reeled.winch) {
    throw std::invalid_argument(fmt::format("{} has a winch or a pulley already", name));
  }
  for (const double rest : reeled.rest) {
    if (std::abs(rest - reeled.rest[0]) <= 1e-6 * rest) continue;
    throw std::invalid_argument(fmt::format("{} has links of {} and {} m, expected equal ones",
                                            name, reeled.rest[0], rest));
  }
  add_winches(world_, reeled, std::move(first), std::move(last));
}

void WorldObject::add_pulley(const Pulley& pulley) {
  refuse_second(world_.pulleys, pulley.name, "pulley");
  taut::add_pulley(world_, pulley.name, pulley.from, pulley.to, pulley.inertia);
  world_.pulleys.back().friction = pulley.friction;
  world_.pulleys.back().bearing = pulley.bearing;
}

std::uint64_t WorldObject::category(const std::string& name) {
  auto found = std::ranges::find(ignored_, name);
  if (found == ignored_.end()) {
    if (ignored_.size() == 64) {
      throw std::invalid_argument("ignores: expected at most 64 names that obstacles ignore");
    }
    found = ignored_.insert(ignored_.end(), name);
  }
  return std::uint64_t{1} << (found - ignored_.begin());
}

void WorldObject::add_obstacle(Obstacle obstacle, const std::vector<std::string>& ignores) {
  refuse_second(world_.obstacles, obstacle.name, "obstacle");
  for (const std::string& name : ignores) {
    const auto body = std::ranges::find(world_.bodies, name, &Body::name);
    std::uint64_t& own =
        body != world_.bodies.end() ? body->capsule.category : connector(name).category;
    own |= category(name);
    obstacle.ignores |= category(name);
  }
  world_.obstacles.push_back(std::move(obstacle));
}

void WorldObject::add_touching(const std::vector<std::string>& bodies,
                               const std::vector<std::string>& connectors,
                               const BodyPair& surfaces) {
  std::vector<std::size_t> free, ropes;
  for (const std::string& name : bodies) {
    free.push_back(index_of(world_.bodies, name, "body"));
    const Body& body = world_.bodies[free.back()];
    if (body.driven()) {
      throw std::invalid_argument(fmt::format("{}: expected a free body", name));
    }
    if (!body.capsule.touches()) {
      throw std::invalid_argument(fmt::format("{}: expected a body with contact", name));
    }
  }
  for (const std::string& name : connectors) {
    ropes.push_back(index_of(world_.connectors, name, "connector"));
  }
  for (std::size_t i = 0; i < free.size(); ++i) {
    for (std::size_t k = i + 1; k < free.size(); ++k) {
      BodyPair& pair = world_.pairs.emplace_back(surfaces);
      std::tie(pair.a, pair.b) = std::minmax(free[i], free[k]);
    }
  }
  for (std::size_t i = 0; i < ropes.size(); ++i) {
    for (const std::size_t body : free) {
      world_.bead_pairs.push_back({ropes[i], body, surfaces.static_friction,
                                   surfaces.kinetic_friction, surfaces.restitution});
    }
    for (std::size_t k = i + 1; k < ropes.size(); ++k) {
      world_.connector_pairs.push_back({ropes[i], ropes[k], surfaces.static_friction,
                                        surfaces.kinetic_friction, surfaces.restitution});
    }
  }
  if (const std::string flaw = pair_flaw(world_); !flaw.empty()) throw std::invalid_argument(flaw);
}

void WorldObject::add_self_contact(const std::string& name, const BodyPair& surfaces) {
  const std::size_t own = index_of(world_.connectors, name, "connector");
  world_.connector_pairs.push_back(
      {own, own, surfaces.static_friction, surfaces.kinetic_friction, surfaces.restitution});
}

void WorldObject::add_force(const std::string& name, const py::function& force) {
  Connector& on = connector(name);
  if (on.applied_force) {
    throw std::invalid_argument(fmt::format("{} has an applied force already", name));
  }
  // Python's lock is free where a method calls, and may be when the last simulation goes.
  const std::shared_ptr<py::function> held(new py::function(force), [](py::function* last) {
    const py::gil_scoped_acquire lock;
    delete last;
  });
  on.applied_force = std::make_shared<const AppliedForce>(
      [held](double time, const std::vector<Vec3>& position, const std::vector<Vec3>& velocity,
             std::vector<Vec3>& sum) {
        const py::gil_scoped_acquire lock;
        const auto rows = static_cast<py::ssize_t>(position.size());
        const auto array = [&](const std::vector<Vec3>& of) {
          return py::array_t<double>({rows, py::ssize_t(3)}, of.data()->data());
        };
        const std::vector<Vec3> found =
            points((*held)(time, array(position), array(velocity)), "applied force");
        if (found.size() != sum.size()) {
          throw std::invalid_argument(
              fmt::format("applied force: expected {} rows, found {}", sum.size(), found.size()));
        }
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += found[i];
      });
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
      .def(
          "add_connector",
          [](WorldObject& world, const std::string& name, const py::object& positions,
             const py::object& mass, const py::object& velocities, double restitution,
             const std::string& model, const std::string& links, double radius,
             const std::string& contact, bool touches_itself, double friction,
             const std::optional<double>& static_friction, double breaks_at,
             const std::optional<double>& diameter, const std::optional<double>& axial_stiffness,
             double axial_damping, const std::optional<double>& bending_stiffness,
             double bending_damping, const py::object& rest_curvature,
             const std::optional<double>& twisting_stiffness, double twisting_damping,
             double rest_twist, const py::object& taper, const py::dict& material,
             const py::dict& drag) {
            Connector made = laid(name,
                                  {positions, mass, velocities, restitution, model, links, contact,
                                   radius, breaks_at},
                                  material);
            give_sections({axial_stiffness, bending_stiffness, twisting_stiffness, axial_damping,
                           bending_damping, twisting_damping, rest_curvature, rest_twist, diameter,
                           taper, material, drag},
                          made);
            const BodyPair own = surfaces(friction, static_friction, restitution);
            if (!touches_itself && (friction > 0 || static_friction)) {
              throw std::invalid_argument("friction: needs touches_itself=True");
            }
            if (touches_itself && made.radius == 0) {
              throw std::invalid_argument("touches_itself: needs a radius above 0");
            }
            world.add_connector(std::move(made));
            if (touches_itself) world.add_self_contact(name, own);
          },
          "name"_a, "positions"_a, "mass"_a = py::none(), py::kw_only(),
          "velocities"_a = py::none(), "restitution"_a = 0.0, "model"_a = "links",
          "links"_a = "rigid", "radius"_a = 0.0, "contact"_a = "beads", "touches_itself"_a = false,
          "friction"_a = 0.0, "static_friction"_a = std::optional<double>(),
          "breaks_at"_a = std::numeric_limits<double>::infinity(),
          "diameter"_a = std::optional<double>(), "axial_stiffness"_a = std::optional<double>(),
          "axial_damping"_a = 0.0, "bending_stiffness"_a = std::optional<double>(),
          "bending_damping"_a = 0.0, "rest_curvature"_a = py::make_tuple(0.0, 0.0, 0.0),
          "twisting_stiffness"_a = std::optional<double>(), "twisting_damping"_a = 0.0,
          "rest_twist"_a = 0.0, "taper"_a = py::none(), "material"_a = py::dict(),
          "drag"_a = py::dict(),
          R"(Adds a rope, chain or cord. Keywords are the keys of a scene's connector.

positions: (n, 3) m; links are as long as they are here. mass: kg, shared evenly by the particles.
velocities: (n, 3) m/s, or None: at rest. restitution: 0 to 1, when the span goes taut. model:
"links", or "span" for a massless span. links: "rigid", or "pull" for strings. radius: m, of what
touches: contact says beads or links. touches_itself: with friction. breaks_at: N, the tension above
which a link is cut. Stiffness and damping: EA (N), EI and GJ (N m^2), their dampings (N s, N m^2 s).
rest_curvature: (3,) 1/m. rest_twist: rad/m. diameter: m, that the air meets; default: twice the
radius. taper: diameters along it as shares. material, in place of mass and stiffness: a dict with
youngs_modulus (Pa), diameter (m), density (kg/m^3) and poissons_ratio. drag: a dict with across and
along.)")
      .def(
          "add_body",
          [](WorldObject& world, const std::string& name, double mass, const py::object& cylinder,
             const py::object& sphere, const py::object& box, const py::object& position,
             const py::object& rotation, const py::object& velocity, const py::object& spin,
             const std::shared_ptr<Path>& path, const py::object& grip,
             const std::optional<py::dict>& contact) {
            Body body;
            body.name = name;
            body.mass_properties = mass_properties(mass, cylinder, sphere, box);
            body.position = vec3(position, "position");
            body.rotation = quaternion(rotation, "rotation");
            body.velocity = vec3(velocity, "velocity");
            body.spin = vec3(spin, "spin");
            body.path = path;
            body.grip = vec3(grip, "grip");
            if (contact && path) {
              throw std::invalid_argument(
                  "contact: needs a free body: an obstacle may have the path of a driven one");
            }
            if (contact) body.capsule = body_capsule(*contact, cylinder, sphere);
            world.add_body(std::move(body));
          },
          "name"_a, "mass"_a, py::kw_only(), "cylinder"_a = py::none(), "sphere"_a = py::none(),
          "box"_a = py::none(), "position"_a = py::make_tuple(0.0, 0.0, 0.0),
          "rotation"_a = py::make_tuple(1.0, 0.0, 0.0, 0.0),
          "velocity"_a = py::make_tuple(0.0, 0.0, 0.0), "spin"_a = py::make_tuple(0.0, 0.0, 0.0),
          "path"_a = std::shared_ptr<Path>(), "grip"_a = py::make_tuple(0.0, 0.0, 0.0),
          "contact"_a = std::optional<py::dict>(),
          R"(Adds a rigid body of `mass` (kg) and one shape, centred on its own origin.

cylinder: (length, diameter) m, along y. sphere: diameter, m. box: (3,) m. position: (3,) m of the
origin. rotation: (4,) w, x, y, z. velocity: (3,) m/s. spin: (3,) rad/s, world axes. path: what
carries its point `grip` (m, own frame); without one it is free. contact: the capsule as which a free
body touches obstacles, a dict with radius, from and to (m, own frame); {}: that of its cylinder or
sphere. None: it touches nothing.)")
      .def(
          "add_obstacle",
          [](WorldObject& world, const std::string& name, bool plane, const py::object& sphere,
             const py::object& capsule, const py::object& cylinder, const py::object& box,
             double rounding, const py::object& position, const py::object& rotation,
             const std::shared_ptr<Path>& path, double friction,
             const std::optional<double>& static_friction, double restitution,
             const std::vector<std::string>& ignores) {
            Obstacle made;
            made.name = name;
            made.shape = surface(plane, sphere, capsule, cylinder, box, rounding);
            made.place = {vec3(position, "position"), quaternion(rotation, "rotation")};
            made.path = path;
            const BodyPair own = surfaces(friction, static_friction, restitution);
            made.static_friction = own.static_friction;
            made.kinetic_friction = own.kinetic_friction;
            made.restitution = own.restitution;
            world.add_obstacle(std::move(made), ignores);
          },
          "name"_a, py::kw_only(), "plane"_a = false, "sphere"_a = py::none(),
          "capsule"_a = py::none(), "cylinder"_a = py::none(), "box"_a = py::none(),
          "rounding"_a = 0.0, "position"_a = py::make_tuple(0.0, 0.0, 0.0),
          "rotation"_a = py::make_tuple(1.0, 0.0, 0.0, 0.0), "path"_a = std::shared_ptr<Path>(),
          "friction"_a = 0.0, "static_friction"_a = std::optional<double>(), "restitution"_a = 0.0,
          "ignores"_a = std::vector<std::string>(),
          R"(Adds a solid of one shape, which beads of connectors and free bodies touch.

plane: all below y = 0 of its frame. sphere: diameter, m. capsule: (length without its caps,
diameter), along y. cylinder: (length, diameter). box: (3,) m. rounding: m, of the edges of a cylinder
or box. position, rotation: of its frame, in space or on a path. friction, static_friction: Coulomb's
coefficients; static_friction: as friction. restitution: 0 to 1. ignores: names of connectors and free
bodies that pass through it.)")
      .def(
          "add_touching",
          [](WorldObject& world, const std::vector<std::string>& bodies,
             const std::vector<std::string>& connectors, double friction,
             const std::optional<double>& static_friction, double restitution) {
            if (bodies.size() + connectors.size() < 2) {
              throw std::invalid_argument("expected at least two names of bodies and connectors");
            }
            world.add_touching(bodies, connectors,
                               surfaces(friction, static_friction, restitution));
          },
          py::kw_only(), "bodies"_a = std::vector<std::string>(),
          "connectors"_a = std::vector<std::string>(), "friction"_a = 0.0,
          "static_friction"_a = std::optional<double>(), "restitution"_a = 0.0,
          R"(Lets free bodies and connectors touch each other; others pass through each other.

bodies: names of free bodies with contact. connectors: their beads touch the bodies, and their links
each other, as capsules of their radius. friction, static_friction, restitution: as of obstacles.)")
      .def("join", &WorldObject::join, "connector"_a, "particle"_a, "other"_a, "other_particle"_a,
           "Makes one of two particles, -1 is the last; those of one connector close a loop.")
      .def(
          "add_winch",
          [](WorldObject& world, const std::string& connector, const py::object& first,
             const py::object& last) {
            if (first.is_none() && last.is_none()) {
              throw std::invalid_argument("add_winch: expected first or last");
            }
            world.add_winch(connector, paid_out(first, "first"), paid_out(last, "last"));
          },
          "connector"_a, py::kw_only(), "first"_a = py::none(), "last"_a = py::none(),
          R"(Lets winches pay rope out at its first or last particle, which is held.

first, last: (k, 2) rows of time (s) and length paid out since the start (m), negative: taken in.)")
      .def(
          "add_pulley",
          [](WorldObject& world, const std::string& name, const std::string& from,
             const std::string& to, double inertia, double friction, double bearing) {
            Pulley made{.name = name};
            made.from = index_of(world.world().connectors, from, "connector");
            made.to = index_of(world.world().connectors, to, "connector");
            made.inertia = not_negative(inertia, "inertia");
            made.friction = not_negative(friction, "friction");
            made.bearing = not_negative(bearing, "bearing");
            world.add_pulley(made);
          },
          "name"_a, "from_connector"_a, "to_connector"_a, py::kw_only(), "inertia"_a = 0.0,
          "friction"_a = 0.0, "bearing"_a = 0.0,
          R"(Lets rope pass from the last end of one connector into the first end of another.

Both ends are held at one place. inertia: kg, of a sheave over the square of its radius. friction:
Coulomb's, on an eye. bearing: of a sheave's axle, times its radius over the sheave's.)")
      .def(
          "set_air",
          [](WorldObject& world, double density, const py::object& wind,
             const std::shared_ptr<Path>& gusts) {
            world.set_air({not_negative(density, "density"), vec3(wind, "wind"), gusts});
          },
          "density"_a = 1.225, py::kw_only(), "wind"_a = py::make_tuple(0.0, 0.0, 0.0),
          "gusts"_a = std::shared_ptr<Path>(),
          R"(Says what connectors with drag move through.

density: kg/m^3. wind: (3,) m/s. gusts: a path whose positions (m) are more wind (m/s).)")
      .def("add_force", &WorldObject::add_force, "connector"_a, "force"_a,
           R"(Lets a function of your own push a connector's particles.

force(time, positions, velocities) returns the forces as an array (n, 3) of N, by the time (s) and
copies (n, 3) of m and m/s. Methods call it as often as they need, in any order: it may depend on
these arguments alone. Pins add particles, cuts divide them.)")
      .def("add_mass", &WorldObject::add_mass, "connector"_a, "particle"_a, "mass"_a,
           "Adds a point mass (kg) to a particle; -1 is the last.")
      .def(
          "hold",
          [](WorldObject& world, const std::string& connector, py::ssize_t particle,
             const py::object& point, const std::optional<std::string>& body,
             const std::shared_ptr<Path>& path, const py::object& clamp, const py::object& turn) {
            auto to = attachment(world.world(), point, body, path);
            if (!to) throw std::invalid_argument("hold: expected a point, a body or a path");
            Hold made{.to = *to};
            if (!clamp.is_none()) {
              made.clamp = vec3(clamp, "clamp");
              if (made.clamp.isZero()) {
                throw std::invalid_argument("clamp: found a vector of length 0");
              }
              made.clamp.normalize();
            }
            if (!turn.is_none()) {
              if (clamp.is_none()) throw std::invalid_argument("turn: needs clamp");
              made.turn = number_path(turn, "turn");
            }
            world.hold(connector, particle, made);
          },
          "connector"_a, "particle"_a, py::kw_only(), "point"_a = py::none(),
          "body"_a = std::optional<std::string>(), "path"_a = std::shared_ptr<Path>(),
          "clamp"_a = py::none(), "turn"_a = py::none(),
          R"(Holds a particle; -1 is the last.

point: (3,) m in space or, with a body or a path, in its frame (default: its origin). clamp: (3,) the
direction of the connector there, from its first particle to its last, in that frame; of one that
resists bending. turn: (k, 2) rows of time (s) and angle (rad) about that direction.)")
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
          "obstacles", [](const WorldObject& world) { return names(world.world().obstacles); },
          "Names of the obstacles.")
      .def_property_readonly(
          "pulleys", [](const WorldObject& world) { return names(world.world().pulleys); },
          "Names of the pulleys.")
      .def_property_readonly(
          "bodies", [](const WorldObject& world) { return names(world.world().bodies); },
          "Names of the bodies.");
}

}  // namespace taut::python
