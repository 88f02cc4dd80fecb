#include "sim/contact/near_links.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <queue>
#include <utility>

namespace taut::contact {
namespace {

/// One of the points that are joined, or of the ends that are at one place, for each point.
std::vector<std::uint32_t> nodes_of(const World& world) {
  std::vector<std::uint32_t> first;
  std::uint32_t points = 0;
  for (const Connector& connector : world.connectors) {
    first.push_back(points);
    points += static_cast<std::uint32_t>(connector.particles());
  }
  std::vector<std::uint32_t> node(points);
  for (std::uint32_t p = 0; p < points; ++p) node[p] = p;
  for (const Joint& joint : world.joints) {
    const auto point = [&](const Joint::Particle& at) {
      return first[at.connector] + static_cast<std::uint32_t>(at.particle);
    };
    std::uint32_t least = point(joint.particles.front());
    for (const Joint::Particle& at : joint.particles) least = std::min(least, point(at));
    for (const Joint::Particle& at : joint.particles) node[point(at)] = least;
  }
  std::map<std::uint32_t, std::uint32_t> ends;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    for (const std::size_t end : {0u, 1u}) {
      if (connector.end_place[end] == 0) continue;
      std::uint32_t& own = node[first[c] + (end == 0 ? 0 : connector.particles() - 1)];
      own = ends.emplace(connector.end_place[end], own).first->second;
    }
  }
  return node;
}

Vec3 place(std::span<const double> position, std::uint32_t point) {
  return Eigen::Map<const Vec3>(position.data() + 3 * std::size_t{point});
}

}  // namespace

NearestShares nearest_shares(const Vec3& from, const Vec3& to, const Vec3& other_from,
                             const Vec3& other_to) {
  const Vec3 e = to - from, f = other_to - other_from, apart = from - other_from;
  const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f);
  const double ea = e.dot(apart), fa = f.dot(apart);
  NearestShares at;
  if (ee == 0 && ff == 0) return at;
  if (ee == 0) {
    at.other = std::clamp(fa / ff, 0.0, 1.0);
    return at;
  }
  if (ff == 0) {
    at.first = std::clamp(-ea / ee, 0.0, 1.0);
    return at;
  }
  constexpr double kParallel = 1e-14;  // of the squared sine
  const double sine = ee * ff - ef * ef;
  if (sine > kParallel * ee * ff) at.first = std::clamp((ef * fa - ff * ea) / sine, 0.0, 1.0);
  at.other = (ef * at.first + fa) / ff;
  if (at.other < 0 || at.other > 1) {
    at.other = std::clamp(at.other, 0.0, 1.0);
    at.first = std::clamp((ef * at.other - ea) / ee, 0.0, 1.0);
  }
  return at;
}

double distance(const Vec3& from, const Vec3& to, const Vec3& other_from, const Vec3& other_to) {
  const NearestShares at = nearest_shares(from, to, other_from, other_to);
  return (from + at.first * (to - from) - other_from - at.other * (other_to - other_from)).norm();
}

void NearLinks::rebuild(const World& world) {
  links_.clear();
  if (world.connector_pairs.empty()) return;
  rules_.assign(world.connectors.size(), {});
  near_along_.clear();
  for (std::uint32_t r = 0; r < world.connector_pairs.size(); ++r) {
    const ConnectorPair& pair = world.connector_pairs[r];
    rules_[pair.a].push_back({static_cast<std::uint32_t>(pair.b), r});
    if (pair.a != pair.b) rules_[pair.b].push_back({static_cast<std::uint32_t>(pair.a), r});
  }
  std::uint32_t first = 0;
  for (std::uint32_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    for (std::uint32_t k = 0; k < connector.links() && !rules_[c].empty(); ++k) {
      links_.push_back({first + k, c, connector.radius});
    }
    std::ranges::sort(rules_[c], {}, &Rule::other);
    first += static_cast<std::uint32_t>(connector.particles());
  }
  if (any()) find_near_along(world);
}

/// Of each point those that are nearer along rope than half a circle of the largest radius.
void NearLinks::find_near_along(const World& world) {
  const std::vector<std::uint32_t> node = nodes_of(world);
  near_along_.resize(node.size());
  std::vector<std::vector<Near>> next(node.size());  // by nodes
  std::vector<std::vector<std::uint32_t>> members(node.size());
  for (std::uint32_t p = 0; p < node.size(); ++p) members[node[p]].push_back(p);
  double thickest = 0;
  std::uint32_t first = 0;
  for (const Connector& connector : world.connectors) {
    for (std::uint32_t k = 0; k < connector.links(); ++k) {
      const std::uint32_t a = node[first + k], b = node[first + k + 1];
      next[a].push_back({b, connector.rest[k]});
      next[b].push_back({a, connector.rest[k]});
    }
    first += static_cast<std::uint32_t>(connector.particles());
  }
  for (const Link& link : links_) thickest = std::max(thickest, link.radius);
  const double most = std::numbers::pi * thickest;
  std::vector<double> along(node.size(), -1);
  for (const Link& link : links_) {
    for (const std::uint32_t start : {link.point, link.point + 1}) {
      if (!near_along_[start].empty()) continue;
      std::vector<std::uint32_t> reached;
      using Item = std::pair<double, std::uint32_t>;
      std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
      queue.emplace(0.0, node[start]);
      while (!queue.empty()) {
        const auto [to, at] = queue.top();
        queue.pop();
        if (along[at] >= 0) continue;
        along[at] = to;
        reached.push_back(at);
        for (const std::uint32_t point : members[at]) near_along_[start].push_back({point, to});
        for (const Near& step : next[at]) {
          if (to + step.along < most) queue.emplace(to + step.along, step.point);
        }
      }
      for (const std::uint32_t at : reached) along[at] = -1;
      std::ranges::sort(near_along_[start], {}, &Near::point);
    }
  }
}

/// Whether two links meet, or less rope than `least` (m) is between them.
bool NearLinks::are_near_along(std::uint32_t a, std::uint32_t b, double least) const {
  for (const std::uint32_t from : {a, a + 1}) {
    for (const std::uint32_t to : {b, b + 1}) {
      const auto at = std::ranges::lower_bound(near_along_[from], to, {}, &Near::point);
      if (at == near_along_[from].end() || at->point != to) continue;
      if (at->along == 0 || at->along < least) return true;
    }
  }
  return false;
}

/// Visits pairs until `visit` returns false: boxes sorted along the axis in which they lie farthest
/// apart.
template <typename Visit>
void NearLinks::each_pair(std::span<const double> position, double within, Visit visit) {
  boxes_.resize(links_.size());
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  for (std::uint32_t i = 0; i < links_.size(); ++i) {
    const Vec3 from = place(position, links_[i].point), to = place(position, links_[i].point + 1);
    const Vec3 room = Vec3::Constant(links_[i].radius + within / 2);
    boxes_[i] = {from.cwiseMin(to) - room, from.cwiseMax(to) + room, i};
    const Vec3 middle = (from + to) / 2;
    sum += middle;
    squares += middle.cwiseProduct(middle);
  }
  int axis = 0;
  const Vec3 mean = sum / static_cast<double>(std::max<std::size_t>(links_.size(), 1));
  (squares - sum.cwiseProduct(mean)).maxCoeff(&axis);
  std::ranges::sort(boxes_, [axis](const Box& one, const Box& other) {
    return std::pair(one.low[axis], one.link) < std::pair(other.low[axis], other.link);
  });
  open_.clear();
  for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
    const Box& box = boxes_[i];
    std::erase_if(open_, [&](std::uint32_t k) { return boxes_[k].high[axis] < box.low[axis]; });
    const Link& own = links_[box.link];
    for (const std::uint32_t k : open_) {
      const Box& other = boxes_[k];
      if ((other.low.array() > box.high.array()).any()) continue;
      if ((other.high.array() < box.low.array()).any()) continue;
      const Link& link = links_[other.link];
      const auto& rules = rules_[own.connector];
      const auto rule = std::ranges::lower_bound(rules, link.connector, {}, &Rule::other);
      if (rule == rules.end() || rule->other != link.connector) continue;
      const double least = std::numbers::pi * std::max(own.radius, link.radius);
      if (are_near_along(own.point, link.point, least)) continue;
      const Vec3 from = place(position, own.point), to = place(position, own.point + 1);
      const Vec3 first = place(position, link.point), last = place(position, link.point + 1);
      const double apart = distance(from, to, first, last);
      if (!(apart <= own.radius + link.radius + within)) continue;
      const auto [a, b] = std::minmax(own.point, link.point);
      if (!visit(LinkPair{a, b, rule->rule})) return;
    }
    open_.push_back(i);
  }
}

void NearLinks::find(std::span<const double> position, double within,
                     std::vector<LinkPair>& pairs) {
  pairs.clear();
  each_pair(position, within, [&](const LinkPair& pair) {
    pairs.push_back(pair);
    return true;
  });
  std::ranges::sort(pairs, {}, [](const LinkPair& pair) { return std::pair(pair.a, pair.b); });
}

double deepest_link(const World& world) {
  NearLinks near;
  near.rebuild(world);
  if (!near.any()) return 0;
  std::vector<Vec3> places;
  std::vector<double> radius;
  for (const Connector& connector : world.connectors) {
    places.insert(places.end(), connector.position.begin(), connector.position.end());
    radius.insert(radius.end(), connector.particles(), connector.radius);
  }
  std::vector<LinkPair> pairs;
  near.find({places.data()->data(), 3 * places.size()}, 0, pairs);
  double most = 0;
  for (const LinkPair& pair : pairs) {
    const double apart =
        distance(places[pair.a], places[pair.a + 1], places[pair.b], places[pair.b + 1]);
    most = std::max(most, radius[pair.a] + radius[pair.b] - apart);
  }
  return most;
}

bool NearLinks::is_any(std::span<const double> position, double within) {
  bool found = false;
  each_pair(position, within, [&](const LinkPair&) {
    found = true;
    return false;
  });
  return found;
}

}  // namespace taut::contact
