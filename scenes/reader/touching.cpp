// Free bodies that touch each other, connectors whose beads touch them, and connectors whose links
// touch each other.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "scenes/reader/reader.h"
#include "sim/contact/capsule.h"
#include "sim/contact/near_links.h"
#include "sim/world/places.h"

namespace taut::scenes {

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
