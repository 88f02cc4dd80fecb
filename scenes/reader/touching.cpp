// Free bodies that touch each other, and connectors whose beads touch them.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "scenes/reader/reader.h"
#include "sim/contact/capsule.h"
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
    const Value &list = *value.find("bodies"), *beads = value.find("connectors");
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
  std::string path_;                                 // of what is being read
  std::map<Pair, std::string> known_, known_beads_;  // where pairs are named
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

}  // namespace

void read_touching(const Document& document, World& world) {
  TouchingReader reader(document, world);
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
}

}  // namespace taut::scenes
