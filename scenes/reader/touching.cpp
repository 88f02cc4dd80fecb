// Free bodies that touch each other.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "scenes/reader/reader.h"
#include "sim/contact/capsule.h"

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
      if (bodies->children[other].find("driven_by")) {
        document.mismatch(name, "a free body: obstacles have `ignores` of their own");
      }
      pairs.insert(std::minmax(b, other));
    }
  }
  return pairs;
}

void refuse_spans_beside(const Document& document) {
  const Value* connectors = document.root.find("connectors");
  for (std::size_t c = 0; connectors && c < connectors->children.size(); ++c) {
    const Value* model = connectors->children[c].find("model");
    if (!model || model->text != "span") continue;
    document.mismatch(*model,
                      "\"links\": no method follows massless spans beside bodies that touch "
                      "each other, and the scene has some");
  }
}

}  // namespace

void read_touching(const Document& document, World& world) {
  const Names names(document.root.find("bodies"));
  const std::set<Pair> ignored = ignored_pairs(document, names);
  const Value* table = document.root.find("touching");
  if (!table || table->children.empty()) return;
  refuse_spans_beside(document);
  std::map<Pair, std::string> known;
  for (const Value& value : table->children) {
    BodyPair surfaces;
    read_friction(document, value, surfaces.static_friction, surfaces.kinetic_friction,
                  surfaces.restitution);
    const Value& list = *value.find("bodies");
    const std::size_t count = list.children.size();
    if (count > kMostPairs || world.pairs.size() + count * (count - 1) / 2 > kMostPairs) {
      document.fail(list, fmt::format("makes more than {} pairs with what is before it: each of "
                                      "its {} bodies touches each other",
                                      kMostPairs, count));
    }
    std::vector<std::size_t> bodies;
    for (const Value& name : list.children) {
      const std::size_t b = names.index_of(document, name, "body");
      const Body& body = world.bodies[b];
      if (body.driven()) {
        document.mismatch(name, "a free body: an obstacle may be carried by a driven one");
      }
      if (!body.capsule.touches()) document.mismatch(name, "a body with contact");
      if (std::ranges::find(bodies, b) != bodies.end()) document.fail(name, "is there twice");
      bodies.push_back(b);
    }
    if (bodies.size() < 2) document.mismatch(list, "at least two bodies");
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      for (std::size_t k = i + 1; k < bodies.size(); ++k) {
        const Pair pair = std::minmax(bodies[i], bodies[k]);
        if (ignored.contains(pair)) continue;
        const auto [at, is_new] = known.emplace(pair, value.path);
        if (!is_new) {
          document.fail(list, fmt::format("has {} and {}, which are in {} already",
                                          world.bodies[pair.first].name,
                                          world.bodies[pair.second].name, at->second));
        }
        BodyPair& made = world.pairs.emplace_back(surfaces);
        made.a = pair.first;
        made.b = pair.second;
      }
    }
  }
}

void check_touching(const Document& document, const World& world) {
  const auto capsule = [](const Body& body) {
    return contact::Capsule{body.point(body.capsule.from), body.point(body.capsule.to),
                            body.capsule.radius};
  };
  for (const BodyPair& pair : world.pairs) {
    const Body &a = world.bodies[pair.a], &b = world.bodies[pair.b];
    const contact::Capsule first = capsule(a), second = capsule(b);
    const double size = (first.to - first.from).norm() + (second.to - second.from).norm() +
                        first.radius + second.radius;
    const double apart = contact::least_gap(first, second);
    if (apart >= -kInside * size) continue;
    document.fail_at_key(*document.root.find("bodies")->find(b.name)->find("contact"),
                         fmt::format("starts {:.6g} m inside of body {}, expected to start outside",
                                     -apart, a.name));
  }
}

}  // namespace taut::scenes
