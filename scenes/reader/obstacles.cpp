#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "scenes/character/capsules.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/contact/capsule.h"
#include "sim/motion/rotation.h"
#include "sim/world/places.h"

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

// Free bodies that touch each other, connectors whose beads touch them, and connectors whose links
// touch each other.

namespace {

using Pair = std::pair<std::size_t, std::size_t>;

constexpr double kInside = 1e-6;  // of the sizes: rounding
constexpr std::size_t kMostPairs = 100'000;

/// Pairs that some body's contact.ignores names, in order.
std::set<Pair> ignored_pairs(const Document& document, const Names& names) {
  std::set<Pair> pairs;
  const Value* bodies = document.root.find("bodies");
  for (std::size_t b = 0; bodies && b < bodies->children.size(); ++b) {
    const Value* contact = bodies->children[b].find("contact");
    const Value* ignores = contact ? contact->find("ignores") : nullptr;
    if (!ignores) continue;
    for (const Value& name : ignores->children) {
      const std::size_t other = names.index_of(document, name, "body");
      if (other == b) document.mismatch(name, "another body");
      if (is_driven(bodies->children[other])) {
        document.mismatch(name, "a free body: obstacles have `ignores` of their own");
      }
      pairs.insert(std::minmax(b, other));
    }
  }
  return pairs;
}

/// Reads the lists of bodies and connectors that touch, and makes pairs of them.
class TouchingReader {
 public:
  TouchingReader(const Document& document, World& world)
      : document_(document),
        world_(world),
        bodies_(document.root.find("bodies")),
        connectors_(names_of_connectors(document)),
        ignored_(ignored_pairs(document, bodies_)) {}

  void read(const Value& value) {
    path_ = value.path;
    BodyPair surfaces;
    read_friction(document_, value, surfaces.static_friction, surfaces.kinetic_friction,
                  surfaces.restitution);
    const Value *list_of_bodies = value.find("bodies"), *beads = value.find("connectors");
    if (!list_of_bodies) {
      if (!beads || beads->children.size() < 2) {
        document_.mismatch(beads ? *beads : value, "bodies, or at least two connectors");
      }
      return pair_connectors(*beads, surfaces);
    }
    const Value& list = *list_of_bodies;
    const std::vector<std::size_t> bodies = bodies_of(list);
    if (bodies.empty()) document_.mismatch(list, "at least one body");
    if (bodies.size() < 2 && !beads) document_.mismatch(list, "at least two bodies, or connectors");
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      for (std::size_t k = i + 1; k < bodies.size(); ++k) {
        const Pair pair = std::minmax(bodies[i], bodies[k]);
        if (ignored_.contains(pair)) continue;
        note(known_, pair, list, world_.bodies[pair.first].name, world_.bodies[pair.second].name);
        BodyPair& made = world_.pairs.emplace_back(surfaces);
        made.a = pair.first;
        made.b = pair.second;
      }
    }
    if (beads) pair_beads(*beads, bodies, surfaces);
    if (beads) pair_connectors(*beads, surfaces);
  }

  /// Pairs the connectors of one name, where that says that it touches itself.
  void read_own(const Value& value) {
    if (!flag_or(value, "touches_itself", false)) {
      for (const char* key : {"friction", "static_friction"}) {
        if (const Value* found = value.find(key)) {
          document_.fail_at_key(*found, "needs touches_itself = true");
        }
      }
      return;
    }
    const Value& key = *value.find("touches_itself");
    path_ = key.path;
    BodyPair surfaces;
    read_friction(document_, value, surfaces.static_friction, surfaces.kinetic_friction,
                  surfaces.restitution);
    const std::vector<std::size_t> own = connectors_named(value.name);
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t k = i; k < own.size(); ++k) pair(own[i], own[k], key, surfaces);
    }
  }

 private:
  static Names names_of_connectors(const Document& document) {
    std::vector<std::string_view> names;
    for (const char* kind : {"connectors", "nets"}) {
      const Value* table = document.root.find(kind);
      for (std::size_t i = 0; table && i < table->children.size(); ++i) {
        names.push_back(table->children[i].name);
      }
    }
    return Names(names);
  }

  std::vector<std::size_t> bodies_of(const Value& list) const {
    const std::size_t count = list.children.size();
    if (count > kMostPairs || world_.pairs.size() + count * (count - 1) / 2 > kMostPairs) {
      document_.fail(list, fmt::format("makes more than {} pairs with what is before it: each of "
                                       "its {} bodies touches each other",
                                       kMostPairs, count));
    }
    std::vector<std::size_t> bodies;
    for (const Value& name : list.children) {
      const std::size_t b = bodies_.index_of(document_, name, "body");
      const Body& body = world_.bodies[b];
      if (body.driven()) {
        document_.mismatch(name, "a free body: an obstacle may be carried by a driven one");
      }
      if (!body.capsule.touches()) document_.mismatch(name, "a body with contact");
      if (std::ranges::find(bodies, b) != bodies.end()) document_.fail(name, "is there twice");
      bodies.push_back(b);
    }
    return bodies;
  }

  void pair_beads(const Value& list, const std::vector<std::size_t>& bodies,
                  const BodyPair& surfaces) {
    for (const Value& name : list.children) {
      connectors_.index_of(document_, name, "connector or net");
      for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
        if (connector_value(document_, world_.connectors[c]).name != name.text) continue;
        for (const std::size_t b : bodies) {
          note(known_beads_, {c, b}, name, world_.connectors[c].name, world_.bodies[b].name);
          world_.bead_pairs.push_back(
              {c, b, surfaces.static_friction, surfaces.kinetic_friction, surfaces.restitution});
        }
        if (world_.bead_pairs.size() > kMostPairs) {
          document_.fail(name, fmt::format("makes more than {} pairs of connectors and bodies with "
                                           "what is before it",
                                           kMostPairs));
        }
      }
    }
  }

  /// Copies of a connector and the cords of a net have its name.
  std::vector<std::size_t> connectors_named(std::string_view name) const {
    std::vector<std::size_t> found;
    for (std::size_t c = 0; c < world_.connectors.size(); ++c) {
      if (connector_value(document_, world_.connectors[c]).name == name) found.push_back(c);
    }
    return found;
  }

  void pair_connectors(const Value& list, const BodyPair& surfaces) {
    std::vector<std::vector<std::size_t>> named;
    for (const Value& name : list.children) {
      connectors_.index_of(document_, name, "connector or net");
      const auto same = [&](const Value& other) {
        return &other != &name && other.text == name.text;
      };
      if (std::ranges::any_of(list.children, same)) document_.fail(name, "is there twice");
      named.push_back(connectors_named(name.text));
    }
    for (std::size_t i = 0; i < named.size(); ++i) {
      for (std::size_t k = i + 1; k < named.size(); ++k) {
        for (const std::size_t a : named[i]) {
          for (const std::size_t b : named[k]) pair(a, b, list.children[k], surfaces);
        }
      }
    }
  }

  void pair(std::size_t a, std::size_t b, const Value& at, const BodyPair& surfaces) {
    for (const std::size_t c : {a, b}) {
      const Connector& connector = world_.connectors[c];
      if (connector.model == ConnectorModel::span) {
        document_.fail(
            at, fmt::format("has {}, a massless span, which touches no connector", connector.name));
      }
      if (connector.radius > 0) continue;
      document_.fail(
          at, fmt::format("has {}, whose radius is 0, expected one above 0", connector.name));
    }
    note(known_connectors_, std::minmax(a, b), at, world_.connectors[a].name,
         world_.connectors[b].name);
    world_.connector_pairs.push_back(
        {a, b, surfaces.static_friction, surfaces.kinetic_friction, surfaces.restitution});
    if (world_.connector_pairs.size() <= kMostPairs) return;
    document_.fail(at, fmt::format("makes more than {} pairs of connectors with what is before it",
                                   kMostPairs));
  }

  void note(std::map<Pair, std::string>& known, const Pair& pair, const Value& list,
            const std::string& a, const std::string& b) {
    const auto [at, is_new] = known.emplace(pair, path_);
    if (is_new) return;
    document_.fail(list, fmt::format("has {} and {}, which are in {} already", a, b, at->second));
  }

  const Document& document_;
  World& world_;
  Names bodies_, connectors_;
  std::set<Pair> ignored_;
  std::string path_;                                                    // of what is being read
  std::map<Pair, std::string> known_, known_beads_, known_connectors_;  // where pairs are named
};

contact::Capsule capsule_of(const Body& body) {
  return {body.point(body.capsule.from), body.point(body.capsule.to), body.capsule.radius};
}

double size_of(const contact::Capsule& capsule) {
  return (capsule.to - capsule.from).norm() + capsule.radius;
}

/// No bead may start inside of a body.
void check_beads(const Document& document, const World& world) {
  for (const BeadPair& pair : world.bead_pairs) {
    const Connector& connector = world.connectors[pair.connector];
    const contact::Capsule capsule = capsule_of(world.bodies[pair.body]);
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (holds(connector, i)) continue;
      const Vec3& at = connector.position[i];
      const double apart = contact::least_gap(capsule, {at, at, connector.radius});
      if (apart >= -kInside * (size_of(capsule) + connector.radius)) continue;
      document.fail(connector_value(document, connector),
                    fmt::format("its particle {} starts {:.6g} m inside of body {}, expected to "
                                "start outside, {} m of radius counted",
                                i, -apart, world.bodies[pair.body].name, connector.radius));
    }
  }
}

/// No link may start inside of another.
void check_links(const Document& document, const World& world) {
  contact::NearLinks near;
  near.rebuild(world);
  if (!near.any()) return;
  std::vector<Vec3> places;
  std::vector<std::size_t> connector_of;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    places.insert(places.end(), connector.position.begin(), connector.position.end());
    connector_of.insert(connector_of.end(), connector.particles(), c);
  }
  std::vector<contact::LinkPair> pairs;
  near.find({places.data()->data(), 3 * places.size()}, 0, pairs);
  for (const contact::LinkPair& pair : pairs) {
    const Connector &a = world.connectors[connector_of[pair.a]],
                    &b = world.connectors[connector_of[pair.b]];
    const double thick = a.radius + b.radius;
    const double apart =
        contact::distance(places[pair.a], places[pair.a + 1], places[pair.b], places[pair.b + 1]);
    if (apart >= (1 - kInside) * thick) continue;
    const auto link = [&](std::uint32_t point, const Connector& of) {
      std::size_t k = 0;
      while (k < point && connector_of[point - k - 1] == connector_of[point]) ++k;
      return fmt::format("link {} of {}", k, of.name);
    };
    document.fail(connector_value(document, b),
                  fmt::format("{} starts {:.6g} m inside of {}, expected to start outside, with "
                              "radii of {} and {} m",
                              link(pair.b, b), thick - apart, link(pair.a, a), b.radius, a.radius));
  }
}

}  // namespace

void read_touching(const Document& document, World& world) {
  TouchingReader reader(document, world);
  for (const char* kind : {"connectors", "nets"}) {
    const Value* table = document.root.find(kind);
    for (std::size_t i = 0; table && i < table->children.size(); ++i) {
      reader.read_own(table->children[i]);
    }
  }
  const Value* table = document.root.find("touching");
  if (!table || table->children.empty()) return;
  for (const Value& value : table->children) reader.read(value);
}

void check_touching(const Document& document, const World& world) {
  for (const BodyPair& pair : world.pairs) {
    const Body &a = world.bodies[pair.a], &b = world.bodies[pair.b];
    const contact::Capsule first = capsule_of(a), second = capsule_of(b);
    const double apart = contact::least_gap(first, second);
    if (apart >= -kInside * (size_of(first) + size_of(second))) continue;
    document.fail_at_key(*document.root.find("bodies")->find(b.name)->find("contact"),
                         fmt::format("starts {:.6g} m inside of body {}, expected to start outside",
                                     -apart, a.name));
  }
  check_beads(document, world);
  check_links(document, world);
}

}  // namespace taut::scenes
