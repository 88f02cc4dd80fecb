#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "scenes/character/capsules.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/names.h"
#include "sim/contact/capsule.h"
#include "sim/motion/rotation.h"

namespace taut::scenes {

namespace {

double read_rounding(const Document& document, const Value& kind, double least) {
  const Value* rounding = kind.find("rounding");
  if (!rounding) return 0;
  if (rounding->number > least / 2) {
    document.mismatch(*rounding,
                      fmt::format("at most half of its smallest size, {:.6g}", least / 2));
  }
  return rounding->number;
}

/// A capsule about the skin that moves with the bone, in its frame.
void fit_to_skin(const Document& document, const Value& bone, const Value& who, Motions& motions,
                 Obstacle& obstacle) {
  const Model& model = *motions.character(motions.character_named(who)).model;
  const auto of_bone = [&](const Capsule& capsule) {
    return model.bones[capsule.bone].name == bone.text;
  };
  const std::vector<Capsule> fitted = fit_capsules(model);
  const auto found = std::ranges::find_if(fitted, of_bone);
  if (found == fitted.end()) document.mismatch(bone, "a bone with skin, or a shape");
  const Eigen::Affine3d bind(model.bones[found->bone].inverse_bind.cast<double>());
  const Vec3 a = bind * found->a, b = bind * found->b;
  const double length = (b - a).norm();
  obstacle.place.position = (a + b) / 2;
  obstacle.shape = sphere_shape(found->radius);
  if (!(length > kRounding * found->radius)) return;  // a ball has no direction
  obstacle.shape = capsule_shape(found->radius, length);
  obstacle.place.rotation = rotation_between(Vec3::UnitY(), b - a);
}

/// The carrier of the obstacle, and its place there.
void read_carrier(const Document& document, const Value& value, Motions& motions,
                  const World& world, Obstacle& obstacle) {
  if (const Value* path = value.find("path")) {
    obstacle.path = motions.path(*path);
  } else if (const Value* name = value.find("body")) {
    const Body& body = world.bodies[motions.body(*name)];
    if (!body.driven()) document.mismatch(*name, "a driven body: free ones carry no obstacle");
    obstacle.path = body.path;
    obstacle.place.position -= body.grip;
  } else if (value.find("bone")) {
    obstacle.path = motions.bone(value);
  }
}

Shape read_surface(const Document& document, const Value& shape) {
  const Value& kind = shape.children.front();
  if (kind.name == "plane") return plane_shape();
  if (kind.name == "box") {
    const Vec3 size = kind.find("size")->vec3();
    return box_shape(size, read_rounding(document, kind, size.minCoeff()));
  }
  const double diameter = kind.find("diameter")->number;
  if (kind.name == "sphere") return sphere_shape(diameter / 2);
  const double length = kind.find("length")->number;
  if (kind.name == "capsule") return capsule_shape(diameter / 2, length);
  return cylinder_shape(diameter / 2, length,
                        read_rounding(document, kind, std::min(diameter, length)));
}

/// Gives each thing that obstacles ignore a category of its own.
class Ignored {
 public:
  Ignored(const Document& document, World& world)
      : document_(document), world_(world), names_(all_names(document)) {}

  /// The categories of what an obstacle's `ignores` names; 0 for null.
  std::uint64_t categories(const Value* ignores) {
    std::uint64_t all = 0;
    if (!ignores) return 0;
    for (const Value& name : ignores->children) all |= category(name);
    return all;
  }

 private:
  /// As the document has them, which stays.
  static std::vector<std::string_view> all_names(const Document& document) {
    std::vector<std::string_view> names;
    for (const char* kind : {"connectors", "nets", "bodies"}) {
      const Value* table = document.root.find(kind);
      for (std::size_t i = 0; table && i < table->children.size(); ++i) {
        const Value& value = table->children[i];
        if (!is_driven(value)) names.push_back(value.name);
      }
    }
    return names;
  }

  std::uint64_t category(const Value& name) {
    const std::size_t index = names_.index_of(document_, name, "connector, net or free body");
    const auto known = bits_.find(index);
    if (known != bits_.end()) return known->second;
    if (bits_.size() == 64)
      document_.fail(name, "is one too many, expected at most 64 names that obstacles ignore");
    const std::uint64_t bit = std::uint64_t{1} << bits_.size();
    bits_[index] = bit;
    for (Connector& c : world_.connectors)
      if (written_name(c.name) == name.text) c.category |= bit;
    for (Body& body : world_.bodies)
      if (body.name == name.text) body.capsule.category |= bit;
    return bit;
  }

  const Document& document_;
  World& world_;
  Names names_;
  std::map<std::size_t, std::uint64_t> bits_;  // by index of the name
};

/// No held particle may be inside of an obstacle, and no bead reach into one.
void check_start(const Document& document, const Value& value, const Obstacle& obstacle,
                 const World& world) {
  const Pose frame = obstacle.frame(0).pose();
  for (const Connector& connector : world.connectors) {
    if (!obstacle.touches(connector.category)) continue;
    const double rounding = kRounding * connector.length;
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      const bool held = std::ranges::any_of(connector.holds,
                                            [&](const Hold& hold) { return hold.particle == i; });
      const double apart =
          gap(obstacle, frame, connector.position[i], held ? 0 : connector.radius).distance;
      if (apart >= -rounding) continue;
      if (held) {
        document.fail(value, fmt::format("is around what holds connector {} (particle {}), {:.6g} "
                                         "m deep, expected to be beside it",
                                         connector.name, i, -apart));
      }
      document.fail(connector_value(document, connector),
                    fmt::format("its particle {} starts {:.6g} m inside of obstacle {}, expected "
                                "to start outside, {} m of radius counted, or start.push_out",
                                i, -apart, obstacle.name, connector.radius));
    }
  }
}

/// Nor may a free body reach into one.
void check_start_of_bodies(const Document& document, const Obstacle& obstacle, const World& world) {
  const Pose frame = obstacle.frame(0).pose();
  for (const Body& body : world.bodies) {
    if (body.driven() || !body.capsule.touches()) continue;
    if (!obstacle.touches(body.capsule.category)) continue;
    const contact::Capsule own{body.point(body.capsule.from), body.point(body.capsule.to),
                               body.capsule.radius};
    const double apart = contact::least_gap(obstacle.shape, frame, own);
    if (apart >= -kRounding * ((own.to - own.from).norm() + own.radius)) continue;
    document.fail_at_key(*document.root.find("bodies")->find(body.name)->find("contact"),
                         fmt::format("starts {:.6g} m inside of obstacle {}, expected to start "
                                     "outside",
                                     -apart, obstacle.name));
  }
}

}  // namespace

Obstacle read_obstacle(const Document& document, const Value& value, Motions& motions,
                       const World& world) {
  Obstacle made;
  made.name = value.name;
  const Value *shape = value.find("shape"), *bone = value.find("bone");
  const Value* who = value.find("character");
  if (who && !bone) document.fail_at_key(*who, "needs bone");
  if (!shape && !bone) document.fail(value, "shape is missing");
  for (const char* key : {"position", "rotation"}) {
    const Value* member = value.find(key);
    if (member && !shape) document.fail_at_key(*member, "needs shape");
  }
  made.place.position = vec3_or(value, "position", Vec3::Zero());
  if (const Value* turned = value.find("rotation")) {
    made.place.rotation = rotation(document, *turned);
  }
  read_carrier(document, value, motions, world, made);
  if (shape) {
    made.shape = read_surface(document, *shape);
  } else {
    fit_to_skin(document, *bone, *who, motions, made);
  }
  read_friction(document, value, made.static_friction, made.kinetic_friction, made.restitution);
  return made;
}

void read_friction(const Document& document, const Value& value, double& static_friction,
                   double& kinetic_friction, double& restitution) {
  kinetic_friction = number_or(value, "friction", 0);
  static_friction = number_or(value, "static_friction", kinetic_friction);
  if (static_friction < kinetic_friction) {
    document.mismatch(*value.find("static_friction"),
                      fmt::format("at least friction, {}", kinetic_friction));
  }
  restitution = number_or(value, "restitution", 0);
}

bool shows_obstacle(const Value& value) {
  return flag_or(value, "shown", !value.find("body") && !value.find("bone"));
}

void read_obstacles(const Document& document, Motions& motions, World& world) {
  const Value* table = document.root.find("obstacles");
  if (!table) return;
  Ignored ignored(document, world);
  for (const Value& value : table->children) {
    Obstacle& made = world.obstacles.emplace_back(read_obstacle(document, value, motions, world));
    made.ignores = ignored.categories(value.find("ignores"));
    if (!made.path || !shows_obstacle(value)) continue;
    Body seen;
    seen.name = made.name;
    seen.path = made.path;
    seen.mass_properties = solid_sphere(1, 1);  // of no account: nothing moves it but its path
    world.bodies.push_back(std::move(seen));
  }
}

void check_obstacles(const Document& document, const World& world) {
  for (std::size_t o = 0; o < world.obstacles.size(); ++o) {
    check_start(document, document.root.find("obstacles")->children[o], world.obstacles[o], world);
    check_start_of_bodies(document, world.obstacles[o], world);
  }
}

}  // namespace taut::scenes
