#include "sim/contact/connector_contacts.h"

#include <algorithm>
#include <optional>

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

/// By how much of its length something that slides by `slip` is held back, if it can be by `push`
/// times the coefficient of friction.
double held_share(const auto& surface, double slip, double push) {
  if (slip <= surface.static_friction * push) return 1;
  return std::min(1.0, surface.kinetic_friction * push / slip);
}

/// The middle line of a ball or a capsule: how near it is costs less than the normal of a surface.
class Core {
 public:
  Core(const Obstacle& obstacle, const Pose& pose)
      : middle_(pose.position),
        axis_(pose.rotation * Vec3::UnitY()),
        half_(obstacle.shape.length / 2),
        radius_(obstacle.shape.radius),
        is_round_(obstacle.shape.kind == Shape::Kind::sphere ||
                  obstacle.shape.kind == Shape::Kind::capsule) {}

  bool is_round() const { return is_round_; }
  /// Whether all within `reach` (m) of a point is outside, with room for rounding.
  bool is_outside(const Vec3& point, double reach) const {
    const double limit = (1 + 1e-9) * (radius_ + reach);
    return is_round_ && from_line(point).squaredNorm() > limit * limit;
  }
  /// Where a way from `a` is nearest to the line, as a share of it, if that is not one of its ends:
  /// the rise of the squared distance is linear but where the line's own ends come to be nearest.
  std::optional<double> nearest(const Vec3& a, const Vec3& way) const {
    const auto rise = [&](double share) { return from_line(a + share * way).dot(way); };
    double low = 0, high = 1, falls = rise(low), rises = rise(high);
    if (!(falls < 0) || !(rises > 0)) return std::nullopt;
    for (const double end : {-half_, half_}) {
      const double share = (end - axis_.dot(a - middle_)) / axis_.dot(way);
      if (!(share > low) || !(share < high)) continue;
      const double there = rise(share);
      (there < 0 ? low : high) = share;
      (there < 0 ? falls : rises) = there;
    }
    return low + (high - low) * falls / (falls - rises);
  }

 private:
  Vec3 from_line(const Vec3& point) const {
    const Vec3 from = point - middle_;
    return from - std::clamp(axis_.dot(from), -half_, half_) * axis_;
  }

  Vec3 middle_, axis_;
  double half_, radius_;
  bool is_round_;
};

struct Nearest {
  double share = 0;  // of the way from one end to the other
  SurfaceDistance distance;
};

/// Of any obstacle: all are convex, so that the distance to them is along a line.
std::optional<double> nearest_share(const Obstacle& obstacle, const Pose& pose, const Vec3& a,
                                    const Vec3& way) {
  constexpr int kSplits = 40;
  const auto rise = [&](double share) {
    return gap(obstacle, pose, a + share * way, 0).normal.dot(way);
  };
  if (!(rise(0) < 0) || !(rise(1) > 0)) return std::nullopt;
  double low = 0, high = 1;
  for (int i = 0; i < kSplits; ++i) {
    const double middle = (low + high) / 2;
    (rise(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The point between a and b that is deepest inside of the obstacle, if one is deeper than the
/// ends: beads are there.
std::optional<Nearest> deepest(const Obstacle& obstacle, const Pose& pose, const Core& core,
                               const Vec3& a, const Vec3& b, double radius) {
  const Vec3 way = b - a;
  const auto at = [&](double share) { return gap(obstacle, pose, a + share * way, radius); };
  if (core.is_round() ? core.is_outside(a + 0.5 * way, radius + way.norm() / 2)
                      : at(0.5).distance > way.norm() / 2)
    return std::nullopt;
  const auto share = core.is_round() ? core.nearest(a, way) : nearest_share(obstacle, pose, a, way);
  if (!share) return std::nullopt;
  const SurfaceDistance distance = at(*share);
  if (distance.distance > 0) return std::nullopt;
  return Nearest{*share, distance};
}

Vec3 between(const double* first, const double* last, double share) {
  if (share == 0) return ConstMap(first);
  return (1 - share) * ConstMap(first) + share * ConstMap(last);
}

/// A bead, or the point of a link at a share of the way between its two beads: places or
/// velocities.
struct Lever {
  double *first, *last;
  double share, first_mobility, last_mobility;

  Vec3 value() const { return between(first, last, share); }
  double mobility() const {
    if (share == 0) return first_mobility;
    return (1 - share) * (1 - share) * first_mobility + share * share * last_mobility;
  }
  /// Changes the value there by `change`, as an impulse at that point does.
  void add(const Vec3& change) const {
    if (share == 0) {
      Map(first) += change;
      return;
    }
    const double left = 1 - share;
    const double mobility = left * left * first_mobility + share * share * last_mobility;
    const Vec3 impulse = change / mobility;
    Map(first) += left * first_mobility * impulse;
    Map(last) += share * last_mobility * impulse;
  }
};

/// The point of one link past that of another.
struct LeverPair {
  Lever one, other;

  Vec3 value() const { return one.value() - other.value(); }
  void add(const Vec3& change) const {
    const double sum = one.mobility() + other.mobility();
    if (one.mobility() > 0) one.add(one.mobility() / sum * change);
    if (other.mobility() > 0) other.add(-other.mobility() / sum * change);
  }
};

/// Of places or velocities, as `part` says where a point has them in the state.
Lever lever(const Mechanism& mechanism, std::size_t (Mechanism::*part)(std::size_t) const,
            std::size_t point, std::size_t next, double share, std::vector<double>& state) {
  const auto& mobile = mechanism.inverse_mass();
  return {&state[(mechanism.*part)(point)], &state[(mechanism.*part)(next)], share, mobile[point],
          mobile[next]};
}

LeverPair levers(const Mechanism& mechanism, std::size_t (Mechanism::*part)(std::size_t) const,
                 const LinkPair& links, const NearestShares& shares, std::vector<double>& state) {
  const auto of = [&](std::size_t point, double share) {
    return lever(mechanism, part, mechanism.leader(point), mechanism.leader(point + 1), share,
                 state);
  };
  return {of(links.a, shares.first), of(links.b, shares.other)};
}

/// The place or velocity of one link's point past that of another.
Vec3 passes(const Mechanism& mechanism, std::size_t (Mechanism::*part)(std::size_t) const,
            const LinkPair& links, const NearestShares& shares, const std::vector<double>& state) {
  const auto at = [&](std::uint32_t point) {
    return Vec3(ConstMap(&state[(mechanism.*part)(mechanism.leader(point))]));
  };
  return (1 - shares.first) * at(links.a) + shares.first * at(links.a + 1) -
         (1 - shares.other) * at(links.b) - shares.other * at(links.b + 1);
}

/// The velocity along a surface of the rope that winches move past a bead, or past the point of a
/// link at a share of the way to its next bead.
Vec3 flow(const Mechanism& mechanism, std::size_t point, std::size_t next, double share,
          const Vec3& normal, const std::vector<double>& state) {
  if (!mechanism.has_winches()) return Vec3::Zero();
  Vec3 past = (1 - share) * mechanism.flow_past(point, state.data());
  if (share > 0) past += share * mechanism.flow_past(next, state.data());
  return past - normal.dot(past) * normal;
}

}  // namespace

void ConnectorContacts::rebuild(const Mechanism& mechanism, const World& world) {
  obstacles_ = world.obstacles;
  radius_.clear();
  category_.clear();
  links_.clear();
  near_.rebuild(world);
  rules_ = world.connector_pairs;
  thickness_.clear();
  leaders_.clear();
  for (const Connector& connector : world.connectors) {
    if (!near_.any()) break;
    thickness_.insert(thickness_.end(), connector.particles(), connector.radius);
  }
  for (std::size_t p = 0; p < thickness_.size(); ++p)
    leaders_.push_back(small(mechanism.leader(p)));
  if (obstacles_.empty()) return;
  radius_.reserve(mechanism.state_room());  // enough for points that pins add
  category_.reserve(mechanism.state_room());
  const auto& mobile = mechanism.inverse_mass();
  if (has_touching_links(world)) links_.reserve(mechanism.state_room());
  met_.reserve(mechanism.state_room());
  for (const Connector& connector : world.connectors) {
    const std::size_t first = radius_.size();
    radius_.insert(radius_.end(), connector.particles(), connector.radius);
    category_.insert(category_.end(), connector.particles(), connector.category);
    for (std::size_t p = first; connector.links_touch && p + 1 < radius_.size(); ++p) {
      const std::size_t a = mechanism.leader(p), b = mechanism.leader(p + 1);
      if (mobile[a] == 0 && mobile[b] == 0) continue;
      links_.push_back({a, b, connector.radius, connector.category});
    }
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mobile[p] == 0) radius_[p] = -1;
  }
}

void ConnectorContacts::find(const Mechanism& mechanism, double time,
                             const std::vector<double>& state) {
  met_.clear();
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const FrameMotion frame = obstacles_[o].frame(time);
    const Core core(obstacles_[o], frame.pose());
    for (std::size_t p = 0; p < radius_.size(); ++p) {
      if (radius_[p] < 0 || !obstacles_[o].touches(category_[p])) continue;
      const Vec3 at = ConstMap(&state[mechanism.position(p)]);
      if (core.is_outside(at, radius_[p])) continue;
      const SurfaceDistance near = gap(obstacles_[o], frame.pose(), at, radius_[p]);
      if (near.distance > 0) continue;
      const Vec3 surface = frame.velocity + frame.spin.cross(at - frame.position);
      met_.push_back({p, p, o, 0, near.normal,
                      surface - flow(mechanism, p, p, 0, near.normal, state), -near.distance});
    }
    if (!links_.empty()) find_links(mechanism, o, frame, state);
  }
}

void ConnectorContacts::find_links(const Mechanism& mechanism, std::size_t obstacle,
                                   const FrameMotion& frame, const std::vector<double>& state) {
  const Core core(obstacles_[obstacle], frame.pose());
  for (const Link& link : links_) {
    if (!obstacles_[obstacle].touches(link.category)) continue;
    const ConstMap a(&state[mechanism.position(link.first)]),
        b(&state[mechanism.position(link.last)]);
    const auto near = deepest(obstacles_[obstacle], frame.pose(), core, a, b, link.radius);
    if (!near) continue;
    const Vec3 at = a + near->share * (b - a);
    const Vec3& normal = near->distance.normal;
    const Vec3 surface = frame.velocity + frame.spin.cross(at - frame.position);
    met_.push_back({link.first, link.last, obstacle, near->share, normal,
                    surface - flow(mechanism, link.first, link.last, near->share, normal, state),
                    -near->distance.distance});
  }
}

/// Finds the links that are inside of each other. Those that have passed each other since `before`
/// go back to their sides.
void ConnectorContacts::find_crossed(const Mechanism& mechanism, double dt,
                                     const std::vector<double>& before,
                                     const std::vector<double>& state) {
  crossed_.clear();
  if (!near_.any()) return;
  near_.find({state.data(), 3 * mechanism.points()}, 0, pairs_);
  const auto& mobile = mechanism.inverse_mass();
  for (LinkPair pair : pairs_) {
    const std::uint32_t a = leaders_[pair.a], b = leaders_[pair.a + 1], c = leaders_[pair.b],
                        d = leaders_[pair.b + 1];
    if (mobile[a] + mobile[b] + mobile[c] + mobile[d] == 0) continue;
    const auto place = [&](std::uint32_t point) {
      return Vec3(ConstMap(&state[mechanism.position(point)]));
    };
    Crossed made{.links = pair, .shares = nearest_shares(place(a), place(b), place(c), place(d))};
    made.thick = thickness_[pair.a] + thickness_[pair.b];
    const auto apart = [&](auto&& at) {
      return Vec3((1 - made.shares.first) * at(a) + made.shares.first * at(b) -
                  (1 - made.shares.other) * at(c) - made.shares.other * at(d));
    };
    const Vec3 now = apart(place);
    const Vec3 was = apart([&](std::uint32_t point) -> Vec3 {
      if (!before.empty()) return ConstMap(&before[mechanism.position(point)]);
      return place(point) - dt * ConstMap(&state[mechanism.velocity(point)]);
    });
    const double distance = now.norm();
    if (!(distance > 0)) continue;
    made.normal = (now.dot(was) < 0 ? -1 : 1) / distance * now;
    made.flow = flow(mechanism, pair.a, pair.a + 1, made.shares.first, made.normal, state) -
                flow(mechanism, pair.b, pair.b + 1, made.shares.other, made.normal, state);
    crossed_.push_back(made);
  }
}

void ConnectorContacts::move_out(const Mechanism& mechanism, double time, double dt,
                                 const std::vector<double>& before, std::vector<double>& state) {
  find(mechanism, time, state);
  for (const Met& met : met_) {
    const Lever at = lever(mechanism, &Mechanism::position, met.point, met.next, met.share, state);
    at.add(met.depth * met.normal);
    const Vec3 was = between(&before[mechanism.position(met.point)],
                             &before[mechanism.position(met.next)], met.share);
    const Vec3 moved = at.value() - was - dt * met.surface;
    const Vec3 slip = moved - met.normal.dot(moved) * met.normal;
    at.add(-held_share(obstacles_[met.obstacle], slip.norm(), met.depth) * slip);
  }
  find_crossed(mechanism, dt, before, state);
  for (const Crossed& at : crossed_) {
    const LeverPair place = levers(mechanism, &Mechanism::position, at.links, at.shares, state);
    // Links beside have moved these already.
    const double depth = at.thick - at.normal.dot(place.value());
    if (depth <= 0) continue;
    place.add(depth * at.normal);
    const Vec3 moved = place.value() + dt * at.flow -
                       passes(mechanism, &Mechanism::position, at.links, at.shares, before);
    const Vec3 slip = moved - at.normal.dot(moved) * at.normal;
    place.add(-held_share(rules_[at.links.rule], slip.norm(), depth) * slip);
  }
}

void ConnectorContacts::rebound(const Mechanism& mechanism, double dt,
                                const std::vector<double>& before, std::vector<double>& state) {
  const double resting = 2 * dt * mechanism.gravity().norm();  // m/s, what gravity alone may make
  for (const Met& met : met_) {
    const Lever at = lever(mechanism, &Mechanism::velocity, met.point, met.next, met.share, state);
    const Vec3 came = between(&before[mechanism.velocity(met.point)],
                              &before[mechanism.velocity(met.next)], met.share);
    const double into = met.normal.dot(met.surface - came);
    const double back = into > resting ? obstacles_[met.obstacle].restitution * into : 0;
    at.add((back - met.normal.dot(at.value() - met.surface)) * met.normal);
  }
  for (const Crossed& at : crossed_) {
    const LeverPair speed = levers(mechanism, &Mechanism::velocity, at.links, at.shares, state);
    const Vec3 came = passes(mechanism, &Mechanism::velocity, at.links, at.shares, before);
    const double into = -at.normal.dot(came);
    const double back = into > resting ? rules_[at.links.rule].restitution * into : 0;
    const double parts = at.normal.dot(speed.value());
    if (parts < back) speed.add((back - parts) * at.normal);
  }
}

void ConnectorContacts::stop(const Mechanism& mechanism, double time, double dt,
                             std::vector<double>& state) {
  find(mechanism, time, state);
  const double resting = 2 * dt * mechanism.gravity().norm();
  for (const Met& met : met_) {
    const Obstacle& obstacle = obstacles_[met.obstacle];
    lever(mechanism, &Mechanism::position, met.point, met.next, met.share, state)
        .add(met.depth * met.normal);
    const Lever at = lever(mechanism, &Mechanism::velocity, met.point, met.next, met.share, state);
    const Vec3 passing = at.value() - met.surface;
    const double into = -met.normal.dot(passing);
    if (into <= 0) continue;
    const double push = into * (1 + (into > resting ? obstacle.restitution : 0));
    const Vec3 slip = passing + into * met.normal;
    at.add(push * met.normal - held_share(obstacle, slip.norm(), push) * slip);
  }
  find_crossed(mechanism, dt, {}, state);
  for (const Crossed& at : crossed_) {
    const LeverPair place = levers(mechanism, &Mechanism::position, at.links, at.shares, state);
    const double depth = at.thick - at.normal.dot(place.value());
    if (depth > 0) place.add(depth * at.normal);
    const LeverPair speed = levers(mechanism, &Mechanism::velocity, at.links, at.shares, state);
    const double into = -at.normal.dot(speed.value());
    if (into <= 0) continue;
    const ConnectorPair& rule = rules_[at.links.rule];
    const double push = into * (1 + (into > resting ? rule.restitution : 0));
    const Vec3 slip = speed.value() + at.flow + into * at.normal;
    speed.add(push * at.normal - held_share(rule, slip.norm(), push) * slip);
  }
}

}  // namespace taut::contact
