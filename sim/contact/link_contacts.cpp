#include "sim/contact/link_contacts.h"

#include <algorithm>
#include <optional>

#include "sim/contact/coulomb.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

struct Nearest {
  double share = 0;
  SurfaceDistance distance;
};

/// The point between a and b that is deepest inside of the obstacle, if one is deeper than the
/// ends: beads are there. Obstacles are convex, so that the distance to them is along a line.
std::optional<Nearest> deepest(const Obstacle& obstacle, const Pose& pose, const Vec3& a,
                               const Vec3& b, double radius) {
  constexpr int kHalvings = 40;
  const Vec3 way = b - a;
  const auto at = [&](double share) { return gap(obstacle, pose, a + share * way, radius); };
  if (at(0.5).distance > way.norm() / 2) return std::nullopt;
  if (!(at(0).normal.dot(way) < 0) || !(at(1).normal.dot(way) > 0)) return std::nullopt;
  double low = 0, high = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (at(middle).normal.dot(way) < 0 ? low : high) = middle;
  }
  const double share = (low + high) / 2;
  const SurfaceDistance distance = at(share);
  if (distance.distance > 0) return std::nullopt;
  return Nearest{share, distance};
}

/// A link's two ends, at a share of the way between them.
struct Lever {
  Map first, last;
  double share, first_mobility, last_mobility;

  double mobility() const {
    return (1 - share) * (1 - share) * first_mobility + share * share * last_mobility;
  }
  Vec3 value() const { return (1 - share) * first + share * last; }
  /// Changes the value there by `change`, as an impulse at that point does.
  void add(const Vec3& change) {
    const Vec3 impulse = change / mobility();
    first += (1 - share) * first_mobility * impulse;
    last += share * last_mobility * impulse;
  }
};

}  // namespace

void LinkContacts::rebuild(const Mechanism& mechanism, const World& world) {
  obstacles_ = world.obstacles;
  links_.clear();
  if (obstacles_.empty()) return;
  links_.reserve(mechanism.state_room());  // enough for points that pins add
  met_.reserve(mechanism.state_room());
  std::size_t first = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t k = 0; connector.links_touch && k + 1 < connector.particles(); ++k) {
      const bool held =
          mechanism.inverse_mass()[first + k] == 0 && mechanism.inverse_mass()[first + k + 1] == 0;
      if (!held) links_.push_back({first + k, connector.radius, connector.category});
    }
    first += connector.particles();
  }
}

void LinkContacts::find(const Mechanism& mechanism, double time, const std::vector<double>& state) {
  met_.clear();
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const FrameMotion frame = obstacles_[o].frame(time);
    for (const Link& link : links_) {
      if (!obstacles_[o].touches(link.category)) continue;
      const ConstMap a(&state[mechanism.position(link.first)]),
          b(&state[mechanism.position(link.first + 1)]);
      const auto near = deepest(obstacles_[o], frame.pose(), a, b, link.radius);
      if (!near) continue;
      const Vec3 at = a + near->share * (b - a);
      met_.push_back({link.first, o, near->share, near->distance.normal,
                      frame.velocity + frame.spin.cross(at - frame.position),
                      -near->distance.distance});
    }
  }
}

namespace {

Lever lever(const Mechanism& mechanism, std::size_t first, double share, std::size_t at_first,
            std::size_t at_last, std::vector<double>& state) {
  return {Map(&state[at_first]), Map(&state[at_last]), share, mechanism.inverse_mass()[first],
          mechanism.inverse_mass()[first + 1]};
}

Lever place(const Mechanism& mechanism, std::size_t first, double share,
            std::vector<double>& state) {
  return lever(mechanism, first, share, mechanism.position(first), mechanism.position(first + 1),
               state);
}

Lever velocity(const Mechanism& mechanism, std::size_t first, double share,
               std::vector<double>& state) {
  return lever(mechanism, first, share, mechanism.velocity(first), mechanism.velocity(first + 1),
               state);
}

}  // namespace

void LinkContacts::move_out(const Mechanism& mechanism, double time, double dt,
                            const std::vector<double>& before, std::vector<double>& state) {
  find(mechanism, time, state);
  for (const Met& met : met_) {
    Lever at = place(mechanism, met.first, met.share, state);
    at.add(met.depth * met.normal);
    const ConstMap a(&before[mechanism.position(met.first)]),
        b(&before[mechanism.position(met.first + 1)]);
    const Vec3 moved = at.value() - ((1 - met.share) * a + met.share * b) - dt * met.surface;
    const Vec3 slip = moved - met.normal.dot(moved) * met.normal;
    at.add(-held_share(obstacles_[met.obstacle], slip.norm(), met.depth) * slip);
  }
}

void LinkContacts::rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
                           std::vector<double>& state) {
  const double resting = 2 * dt * mechanism.gravity().norm();  // m/s, what gravity alone may make
  for (const Met& met : met_) {
    Lever at = velocity(mechanism, met.first, met.share, state);
    const ConstMap a(&before[mechanism.velocity(met.first)]),
        b(&before[mechanism.velocity(met.first + 1)]);
    const Vec3 came = (1 - met.share) * a + met.share * b;
    const double into = met.normal.dot(met.surface - came);
    const double back = into > resting ? obstacles_[met.obstacle].restitution * into : 0;
    at.add((back - met.normal.dot(at.value() - met.surface)) * met.normal);
  }
}

void LinkContacts::stop(const Mechanism& mechanism, double time, double dt,
                        std::vector<double>& state) {
  find(mechanism, time, state);
  const double resting = 2 * dt * mechanism.gravity().norm();
  for (const Met& met : met_) {
    const Obstacle& obstacle = obstacles_[met.obstacle];
    place(mechanism, met.first, met.share, state).add(met.depth * met.normal);
    Lever at = velocity(mechanism, met.first, met.share, state);
    const Vec3 passing = at.value() - met.surface;
    const double into = -met.normal.dot(passing);
    if (into <= 0) continue;
    const double push = into * (1 + (into > resting ? obstacle.restitution : 0));
    const Vec3 slip = passing + into * met.normal;
    at.add(push * met.normal - held_share(obstacle, slip.norm(), push) * slip);
  }
}

}  // namespace taut::contact
