#include "sim/contact/capsule.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <queue>
#include <utility>

#include "sim/motion/rotation.h"
#include "sim/motion/types.h"
#include "sim/world/places.h"

namespace taut::contact {
namespace {

constexpr double kTurn = 1e-2;      // rad: turned by that, what lies flat touches at one end of it
constexpr double kCrosses = 10;     // cot^2 of 17 degrees: what crosses by more does not lie flat
constexpr double kSameSpot = 1e-6;  // of the axis: spots so near to each other are one
constexpr double kParallel =
    1e-10;                        // of the axis' length: distances so near to each other are equal
constexpr double kEvenly = 1e-9;  // rad: slopes so near to each other are one
constexpr int kBisections = 54;   // of a double's fraction
constexpr int kToCell = 40;       // of these, down to a cell that may be guessed
constexpr double kCell = 0x1p-40;
constexpr int kGuesses = 20;  // of a guess

/// The first and the last of what lies flat, and whether distances rise evenly between.
struct Flat {
  double first = 0, last = 0;
  bool even = false;
};

/// A capsule's axis in the frame of a solid.
struct Axis {
  Axis(const Shape& of, const Pose& frame, const Capsule& capsule)
      : shape(of),
        from(frame.rotation.conjugate() * (capsule.from - frame.position)),
        way(frame.rotation.conjugate() * (capsule.to - capsule.from)),
        length(way.norm()) {}

  SurfaceDistance at(double along) const { return shape.from(from + along * way); }

  /// Where distances plus `turn` (rad) times the way along the axis are least: they are convex, so
  /// that their slope rises.
  double least(double turn) const {
    const auto rise = [&](double along) { return at(along).normal.dot(way) + turn * length; };
    const double first = rise(0), last = rise(1);
    if (first >= 0) return 0;
    if (!(last >= 0)) return 1;
    // The cell of a grid that halvings would come to, or else all of the axis.
    double low = std::clamp(guess(first, last, rise), 0.0, 1 - kCell), high = low + kCell;
    int halvings = kBisections - kToCell;
    if (rise(low) >= 0 || !(rise(high) >= 0)) low = 0, high = 1, halvings = kBisections;
    for (; halvings > 0; --halvings) {
      const double middle = (low + high) / 2;
      (rise(middle) >= 0 ? high : low) = middle;
    }
    return high;
  }

  /// Where `rise` may cross zero, which it does in kCell of that: regula falsi, by Illinois.
  static double guess(double first, double last, const auto& rise) {
    double low = 0, high = 1, along = 0;
    bool rose = false;
    for (int i = 0; i < kGuesses; ++i) {
      const double before = along;
      along = (low * last - high * first) / (last - first);
      if (!(along > low && along < high) || std::abs(along - before) < kCell / 8) break;
      const double there = rise(along);
      const bool rises = there >= 0, again = i > 0 && rises == rose;
      if (rises) {
        high = along, last = there;
        if (again) first /= 2;
      } else {
        low = along, first = there;
        if (again) last /= 2;
      }
      rose = rises;
    }
    return std::floor(along / kCell) * kCell;
  }

  /// An end of what lies flat, where the turned axis touches a rounded edge beside it: the point of
  /// the axis over the curve's centre is where it lies.
  double over_curve(double along) const {
    if (!(along > 0 && along < 1)) return along;
    const SurfaceDistance near = at(along);
    const double rounding = shape.kind == Shape::Kind::capsule ? shape.radius : shape.rounding;
    const Vec3 centre = from + along * way - (near.distance + rounding) * near.normal;
    return std::clamp(way.dot(centre - from) / (length * length), 0.0, 1.0);
  }

  double slope(double along) const { return at(along).normal.dot(way) / length; }

  /// The first and the last of what lies flat. Over a face that is flat itself distances rise
  /// evenly; tipped about an end, the axis touches the edge beside it.
  Flat flat_ends() const {
    const double low = least(kTurn), high = least(-kTurn), tilt = slope((low + high) / 2);
    const double first = least(kEvenly - tilt), last = least(-kEvenly - tilt);
    if (!(last - first > (high - low) / 2)) return {over_curve(low), over_curve(high), false};
    const double nearest = least(0);
    return {std::min(first, nearest), std::max(last, nearest), true};
  }

  double along(Spot spot) const {
    if (spot == Spot::from || !(length > 0)) return 0;
    if (spot == Spot::to) return 1;
    return least(0);
  }

  const Shape& shape;
  Vec3 from, way;
  double length;
};

/// m, of the axis of a capsule that rolls over an edge or a round solid.
double curve(const Shape& shape, double radius) {
  const bool round = shape.kind == Shape::Kind::capsule || shape.kind == Shape::Kind::cylinder;
  return radius + (round ? shape.radius : shape.rounding);
}

bool lies_flat(const Shape& shape) {
  return shape.kind != Shape::Kind::plane && shape.kind != Shape::Kind::sphere;
}

SpotGap gap_of(const Axis& axis, const Pose& frame, double radius, double along) {
  const SurfaceDistance near = axis.at(along);
  return {along, near.distance - radius, frame.rotation * near.normal};
}

}  // namespace

SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, double along) {
  return gap_of(Axis(shape, frame, capsule), frame, capsule.radius, along);
}

SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, Spot spot) {
  const Axis axis(shape, frame, capsule);
  if (spot <= Spot::nearest || !(axis.length > 0)) {
    return gap_of(axis, frame, capsule.radius, axis.along(spot));
  }
  const Flat flat = axis.flat_ends();
  SpotGap gap = gap_of(axis, frame, capsule.radius, spot == Spot::first ? flat.first : flat.last);
  gap.even = flat.even;
  return gap;
}

std::array<SpotGap, 5> all_gaps(const Shape& shape, const Pose& frame, const Capsule& capsule) {
  const Axis axis(shape, frame, capsule);
  std::array<SpotGap, 5> gaps;
  const bool point = !(axis.length > 0);
  Flat ends;
  if (!point && lies_flat(shape)) ends = axis.flat_ends();
  for (const Spot spot : kSpots) {
    SpotGap& gap = gaps[static_cast<std::size_t>(spot)];
    const bool end = spot == Spot::from || spot == Spot::to;
    if (!end && (shape.kind == Shape::Kind::plane || point)) {
      gap = gaps[0];
      gap.distinct = false;
      continue;
    }
    if (spot > Spot::nearest && !lies_flat(shape)) {
      gap = gaps[2];
      gap.distinct = false;
      continue;
    }
    const bool flat = spot == Spot::first || spot == Spot::last;
    const double along = flat ? (spot == Spot::first ? ends.first : ends.last) : axis.along(spot);
    gap = gap_of(axis, frame, capsule.radius, along);
    gap.even = flat && ends.even;
    if (!end) gap.distinct = gap.along > kSameSpot && gap.along < 1 - kSameSpot;
    if (spot == Spot::to) gap.distinct = !point;
  }
  const auto apart = [&](std::size_t i, std::size_t k) {
    return std::abs(gaps[i].along - gaps[k].along) > kSameSpot;
  };
  // An axis that crosses a round solid at an angle a: they are 2 kTurn cot^2(a) of the radii apart.
  const double between = axis.length * std::abs(gaps[4].along - gaps[3].along);
  const double rolls = 2 * kTurn * curve(shape, capsule.radius);
  if (!apart(3, 4) || between < kCrosses * rolls) {  // it does not lie flat
    gaps[3].distinct = gaps[4].distinct = false;
  } else if (!apart(2, 3) || !apart(2, 4)) {
    gaps[2].distinct = false;
  }
  bool before = false, behind = false;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (i == 2 || !gaps[i].distinct) continue;
    if (gaps[i].distance > gaps[2].distance + kParallel * axis.length) continue;
    (gaps[i].along < gaps[2].along ? before : behind) = true;
  }
  if (before && behind) gaps[2].distinct = false;
  return gaps;
}

double least_gap(const Shape& shape, const Pose& frame, const Capsule& capsule) {
  const Axis axis(shape, frame, capsule);
  double least = std::min(axis.at(0).distance, axis.at(1).distance);
  if (shape.kind != Shape::Kind::plane && axis.length > 0) {
    least = std::min(least, axis.at(axis.least(0)).distance);
  }
  return least - capsule.radius;
}

double least_gap(const Capsule& solid, const Capsule& capsule) {
  const Vec3 way = solid.to - solid.from;
  const double length = way.norm();
  const Pose frame{solid.at(0.5),
                   length > 0 ? rotation_between(Vec3::UnitY(), way) : Quat::Identity()};
  const Shape shape = length > 0 ? capsule_shape(solid.radius, length) : sphere_shape(solid.radius);
  return least_gap(shape, frame, capsule);
}

double penetration_max(const World& world) {
  double most = 0;
  for (const Obstacle& obstacle : world.obstacles) {
    const Pose frame = obstacle.frame(world.time).pose();
    for (const Connector& connector : world.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        if (holds(connector, i)) continue;
        const Vec3& at = connector.position[i];
        most = larger(most, -gap(obstacle, frame, at, connector.radius).distance);
      }
    }
    for (const Body& body : world.bodies) {
      const BodyCapsule& own = body.capsule;
      if (body.driven() || !own.touches() || !obstacle.touches(own.category)) continue;
      const Capsule capsule{body.point(own.from), body.point(own.to), own.radius};
      most = larger(most, -least_gap(obstacle.shape, frame, capsule));
    }
  }
  return larger(most, deepest_link(world));
}

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
