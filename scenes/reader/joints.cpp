#include "scenes/reader/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace taut::scenes {
namespace {

/// Particles that are one, found together in nearly linear time.
class Groups {
 public:
  void unite(const Joint::Particle& a, const Joint::Particle& b) {
    const std::size_t first = find(node(a)), second = find(node(b));
    parent_[std::max(first, second)] = std::min(first, second);
  }

  /// In the order in which their first particles were named.
  std::vector<Joint> joints() {
    std::vector<Joint> all;
    std::vector<std::size_t> index(parent_.size());
    for (std::size_t n = 0; n < parent_.size(); ++n) {
      const std::size_t root = find(n);
      if (root == n) {
        index[n] = all.size();
        all.emplace_back();
      }
      all[index[root]].particles.push_back(particles_[n]);
    }
    return all;
  }

 private:
  std::size_t node(const Joint::Particle& at) {
    const auto [found, added] = number_.try_emplace({at.connector, at.particle}, particles_.size());
    if (added) {
      parent_.push_back(particles_.size());
      particles_.push_back(at);
    }
    return found->second;
  }
  std::size_t find(std::size_t node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }

  std::map<std::pair<std::size_t, std::size_t>, std::size_t> number_;
  std::vector<Joint::Particle> particles_;
  std::vector<std::size_t> parent_;
};

}  // namespace

JoinedEnds::JoinedEnds(const Document& document, const Value* connectors, const World& world)
    : document_(document), joined_to_(world.connectors.size()) {
  const Names names(connectors);
  for (std::size_t c = 0; connectors && c < connectors->children.size(); ++c) {
    const Value& connector = connectors->children[c];
    read(names, world, *connector.find("from"), {c, 0});
    read(names, world, *connector.find("to"), {c, world.connectors[c].particles() - 1});
  }
}

void JoinedEnds::read(const Names& names, const World& world, const Value& end,
                      Joint::Particle own) {
  const Value *name = end.find("connector"), *at = end.find("at");
  if (at && !name) document_.fail_at_key(*at, "needs connector");
  if (!name) return;
  if (!at) document_.fail_at_key(*name, "needs at, the place along the connector");
  const std::size_t other = names.index_of(document_, *name, "connector");
  for (const std::size_t c : {own.connector, other}) {
    if (world.connectors[c].model == ConnectorModel::span) {
      document_.fail_at_key(
          *name, fmt::format("{} is a massless span, expected model = \"links\" of what is joined",
                             world.connectors[c].name));
    }
  }
  const Connector& connector = world.connectors[other];
  if (at->number > connector.length) {
    document_.mismatch(
        *at, fmt::format("at most the length of {}, {} m", connector.name, connector.length));
  }
  const double link = connector.rest.front();
  const double nearest = link > 0 ? std::round(at->number / link) : 0;
  if (std::abs(at->number - nearest * link) > kRounding * connector.length) {
    document_.mismatch(*at, fmt::format("the place of a particle of {}, such as {:.6g} m",
                                        connector.name, nearest * link));
  }
  const Joint::Particle target{other, static_cast<std::size_t>(nearest)};
  const auto [low, high] = std::minmax(own.particle, target.particle);
  if (other == own.connector && high - low < 3) {
    document_.fail_at_key(*name, fmt::format("joins the connector to itself with {} links between, "
                                             "expected at least 3",
                                             high - low));
  }
  joined_to_[other].push_back(own.connector);
  index_.emplace(std::pair(own.connector, own.particle), ends_.size());
  ends_.push_back({&end, own, target});
}

std::optional<Joint::Particle> JoinedEnds::target(std::size_t connector,
                                                  std::size_t particle) const {
  const auto found = index_.find({connector, particle});
  if (found == index_.end()) return std::nullopt;
  return ends_[found->second].other;
}

bool JoinedEnds::is_loop(std::size_t connector, std::size_t last) const {
  const auto to = target(connector, last);
  return to && to->connector == connector && to->particle == 0;
}

void JoinedEnds::join(World& world) const {
  if (ends_.empty()) return;
  Groups groups;
  for (const End& end : ends_) {
    const Connector &own = world.connectors[end.own.connector],
                    &other = world.connectors[end.other.connector];
    const double apart =
        (own.position[end.own.particle] - other.position[end.other.particle]).norm();
    const double largest = other.position[end.other.particle].cwiseAbs().maxCoeff();
    if (apart > apart_by_rounding(std::max(own.length, other.length), largest)) {
      document_.fail(*end.value,
                     fmt::format("is {:.6g} m away from its place on {} at the start, expected it "
                                 "to begin there",
                                 apart, other.name));
    }
    groups.unite(end.other, end.own);
  }
  world.joints = groups.joints();
  const std::string flaw = joint_flaw(world);
  if (!flaw.empty()) document_.fail(*ends_.back().value, flaw + ", expected other places");
}

}  // namespace taut::scenes
