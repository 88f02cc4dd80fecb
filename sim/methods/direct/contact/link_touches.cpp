#include "sim/methods/direct/contact/link_touches.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/hash.h"
#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

using contact::Capsule;
using contact::Spot;
using contact::SpotGap;
using ConstMap = Eigen::Map<const Vec3>;
using State = contact::Touch::State;

constexpr double kNoLever = 1e-12;  // of a bead's mobility: what is held does not touch

}  // namespace

void LinkTouches::rebuild(const World& world, const Mechanism& mechanism) {
  links_.clear();
  touches_.clear();
  before_.clear();
  const auto& mobile = mechanism.inverse_mass();
  std::vector<std::uint32_t> carried(mechanism.points(), kNone);
  for (std::size_t i = 0; i < mechanism.body_points().size(); ++i) {
    carried[mechanism.body_points()[i].point] = small(i);
  }
  const auto is_held = [&](std::uint32_t p) { return mobile[p] == 0 && carried[p] == kNone; };
  std::uint32_t first = 0;
  for (const Connector& connector : world.connectors) {
    const auto count = static_cast<std::uint32_t>(connector.particles());
    for (std::uint32_t p = first; connector.links_touch && p + 1 < first + count; ++p) {
      if (is_held(p) && is_held(p + 1)) continue;
      Link made{p, connector.radius, connector.category, {carried[p], carried[p + 1]}, {}};
      made.spots = {Spot::nearest, Spot::first, Spot::last};
      // Where a free body holds it, no bead touches, but the end of the link does.
      if (carried[p] != kNone && p == first) made.spots.push_back(Spot::from);
      if (carried[p + 1] != kNone) made.spots.push_back(Spot::to);
      links_.push_back(made);
    }
    first += count;
  }
}

Capsule LinkTouches::capsule(const Step& step, const std::vector<double>& state,
                             std::uint32_t link) const {
  const Link& own = links_[link];
  return {ConstMap(&state[step.mechanism.position(own.first)]),
          ConstMap(&state[step.mechanism.position(own.first + 1)]), own.radius};
}

/// m/s, of a point of a link where the step begins.
Vec3 LinkTouches::velocity(const Step& step, std::uint32_t link, double share) const {
  const std::uint32_t point = links_[link].first;
  return (1 - share) * ConstMap(&step.state[step.mechanism.velocity(point)]) +
         share * ConstMap(&step.state[step.mechanism.velocity(point + 1)]);
}

bool LinkTouches::is_known(std::uint32_t link, std::uint32_t obstacle, Spot spot) const {
  return std::ranges::any_of(touches_, [&](const LinkTouch& at) {
    return at.link == link && at.obstacle == obstacle && at.spot == spot;
  });
}

bool LinkTouches::find(const Step& step, double least) {
  bool arrives = false;
  before_.swap(touches_);
  touches_.clear();
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    const Capsule own = capsule(step, step.state, link);
    const double size = (own.to - own.from).norm();
    for (std::uint32_t o = 0; o < step.obstacles.size(); ++o) {
      const Obstacle& obstacle = step.obstacles[o];
      const FrameMotion& frame = step.start[o];
      if (!obstacle.touches(links_[link].category)) continue;
      if (contact::gap_at(obstacle.shape, frame.pose(), own, 0.5).distance > size) continue;
      const auto gaps = contact::all_gaps(obstacle.shape, frame.pose(), own);
      for (const Spot spot : links_[link].spots) {
        const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
        if (!near.distinct || near.distance > step.touching) continue;
        const Vec3 local = frame.rotation.conjugate() * (own.at(near.along) - frame.position);
        const Vec3 past = velocity(step, link, near.along) - frame.point(local).velocity;
        const double leaving = near.normal.dot(past);
        if (leaving > step.touching) continue;
        const bool hits = -leaving * obstacle.restitution > least;
        arrives = arrives || hits;
        add(step, {.link = link,
                   .obstacle = o,
                   .spot = spot,
                   .hits = hits,
                   .anchor = local,
                   .side = frame.rotation.conjugate() * near.normal,
                   .normal_start = Vec3::Zero()});
      }
    }
  }
  return arrives;
}

void LinkTouches::add(const Step& step, const Hit& hit) {
  if (is_known(hit.link, hit.obstacle, hit.spot)) return;
  add(step, {.link = hit.link,
             .obstacle = hit.obstacle,
             .spot = hit.spot,
             .hits = true,
             .anchor = hit.anchor,
             .side = hit.side,
             .normal_start = Vec3::Zero()});
}

/// Adds a touch where it stands in order.
void LinkTouches::add(const Step& step, LinkTouch made) {
  const Obstacle& obstacle = step.obstacles[made.obstacle];
  const FrameMotion& frame = step.start[made.obstacle];
  const Capsule own = capsule(step, step.state, made.link);
  const SpotGap near = contact::gap_at(obstacle.shape, frame.pose(), own, made.spot);
  made.share_start = made.share = near.along;
  made.normal_start = near.normal;
  made.touch.stick = obstacle.static_friction;
  made.touch.slide = obstacle.kinetic_friction;
  const bool stuck = std::ranges::any_of(before_, [&](const LinkTouch& was) {
    return was.link == made.link && was.obstacle == made.obstacle &&
           was.touch.state == State::sticks;
  });
  if (!stuck) {
    const Vec3 from = own.at(near.along) - frame.position;
    made.touch.sliding =
        velocity(step, made.link, near.along) - frame.velocity - frame.spin.cross(from);
  }
  const auto place = std::ranges::upper_bound(touches_, made.link, {}, &LinkTouch::link);
  touches_.insert(place, made);
}

void LinkTouches::scale_friction(const std::vector<Obstacle>& obstacles, double share) {
  for (LinkTouch& at : touches_) {
    at.touch.stick = share * obstacles[at.obstacle].static_friction;
    at.touch.slide = share * obstacles[at.obstacle].kinetic_friction;
  }
}

void LinkTouches::release() {
  take_back_kicks();
  for (LinkTouch& at : touches_) {
    at.given.setZero();
    at.touch.push = 0;
    at.touch.state = State::open;
  }
}

void LinkTouches::keep() {
  kept_.clear();
  for (const LinkTouch& at : touches_) kept_.push_back(at.given);
}

void LinkTouches::restore() {
  for (std::size_t i = 0; i < touches_.size(); ++i) touches_[i].given = kept_[i];
}

/// 1/kg, of a bead of a link; of one that a free body carries, on the average of all directions.
double LinkTouches::mobility(const Mechanism& mechanism, const Link& link, std::size_t end) const {
  if (link.carried[end] == kNone) return mechanism.inverse_mass()[link.first + end];
  const auto& carried = mechanism.body_points()[link.carried[end]];
  const auto& body = mechanism.bodies()[carried.body];
  const Mat3 lever = cross_matrix(carried.arm);
  return body.inverse_mass - (lever * body.world_inverse * lever).trace() / 3;
}

void LinkTouches::set_mobility(LinkTouch& at, const Step& step) const {
  const Link& link = links_[at.link];
  const double first = mobility(step.mechanism, link, 0);
  const double next = mobility(step.mechanism, link, 1);
  const double left = 1 - at.share;
  at.mobility = left * left * first + at.share * at.share * next;
  // Where a held end touches, nothing moves.
  at.mobility = std::max(at.mobility, kNoLever * std::max(first, next));
}

void LinkTouches::give(std::span<const double> inverse_mass, std::span<Vec3> velocity) const {
  for (const LinkTouch& at : touches_) {
    const std::uint32_t point = links_[at.link].first;
    velocity[point] += (1 - at.share) * inverse_mass[point] * at.given;
    velocity[point + 1] += at.share * inverse_mass[point + 1] * at.given;
  }
}

/// Gives the body that carries one of a touch's beads, if there is one, its share of an impulse.
void LinkTouches::kick(const Mechanism& mechanism, const LinkTouch& at, std::size_t end,
                       const Vec3& impulse, const Vec3& arm, const Mat3& inverse,
                       std::vector<double>& twists) const {
  const auto& carried = mechanism.body_points()[links_[at.link].carried[end]];
  const Vec3 given = (end == 0 ? 1 - at.share : at.share) * impulse;
  Eigen::Map<contact::Vec6> u(&twists[mechanism.twist(carried.body)]);
  u.head<3>() += mechanism.bodies()[carried.body].inverse_mass * given;
  u.tail<3>() += inverse * arm.cross(given);
}

void LinkTouches::kick(const Mechanism& mechanism, std::span<const Vec3> arm,
                       std::span<const Mat3> inverse, std::vector<double>& twists) const {
  for (const LinkTouch& at : touches_) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t carried = links_[at.link].carried[end];
      if (carried == kNone) continue;
      const Mat3& of_body = inverse[mechanism.body_points()[carried].body];
      kick(mechanism, at, end, at.given, arm[carried], of_body, twists);
    }
  }
}

void LinkTouches::kick_more(const Mechanism& mechanism, std::vector<double>& twists) {
  for (LinkTouch& at : touches_) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t carried = links_[at.link].carried[end];
      if (carried == kNone) continue;
      const auto& point = mechanism.body_points()[carried];
      kick(mechanism, at, end, at.given - at.kicked, point.arm,
           mechanism.bodies()[point.body].world_inverse, twists);
    }
    at.kicked = at.given;
  }
}

void LinkTouches::take_back_kicks() {
  for (LinkTouch& at : touches_) at.kicked.setZero();
}

/// By how much a touch breaks its law: that of a bead whose velocity without what it gets is that
/// of the link there.
void LinkTouches::find_error(LinkTouch& at, std::span<const Vec3> velocity, double creep) {
  const std::uint32_t point = links_[at.link].first;
  const Vec3 moves = (1 - at.share) * velocity[point] + at.share * velocity[point + 1];
  const contact::Response found =
      contact::respond(moves - at.mobility * at.given, std::span(&at.touch, 1), creep);
  at.error = found.velocity - moves;
  at.derivative = found.derivative;
}

void LinkTouches::find_errors(std::span<const Vec3> velocity, double creep) {
  for (LinkTouch& at : touches_) find_error(at, velocity, creep);
}

double LinkTouches::error(std::span<const double> noise) const {
  double worst = 0;
  for (const LinkTouch& at : touches_) {
    const std::uint32_t point = links_[at.link].first;
    const double rounding = noise.empty() ? 0 : noise[point] + noise[point + 1];
    worst = std::max(worst, at.error.norm() - rounding);
  }
  return worst;
}

void LinkTouches::linearize() {
  linear_.clear();
  missing_.clear();
  for (const LinkTouch& at : touches_) {
    linear_.push_back({.first = links_[at.link].first,
                       .share = at.share,
                       .mobility = at.mobility,
                       .derivative = at.derivative,
                       .bend_first = Mat3::Zero(),
                       .bend_next = Mat3::Zero(),
                       .slope_first = Vec3::Zero(),
                       .slope_next = Vec3::Zero(),
                       .given = at.given,
                       .apart = Vec3::Zero()});
    missing_.push_back(-at.error);
  }
}

void LinkTouches::linearize(const Step& step, const std::vector<double>& next,
                            std::span<const Vec3> velocity, std::span<const Vec3> behind,
                            double creep) {
  linearize();
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const LinkTouch& at = touches_[i];
    GlideSystem::LinkTouch& made = linear_[i];
    made.apart = velocity[made.first + 1] - velocity[made.first];
    if (at.touch.push > 0) bend(step, next, at, velocity, creep, made);
    const Vec3 late = (1 - at.share) * behind[made.first] + at.share * behind[made.first + 1];
    missing_[i] += at.derivative * late - late;
  }
}

void LinkTouches::advance(double share) {
  for (std::size_t i = 0; i < touches_.size(); ++i) touches_[i].given += share * missing_[i];
}

double LinkTouches::residual() const {
  double worst = 0;
  for (const LinkTouch& at : touches_) {
    worst = std::max(worst, at.touch.push > 0 ? std::abs(at.gap) : -at.gap);
  }
  return worst;
}

double LinkTouches::most_stuck() const {
  double most = 0;
  for (const LinkTouch& at : touches_) {
    if (at.touch.state == State::sticks) most = std::max(most, at.touch.friction.norm());
  }
  return most;
}

std::uint64_t LinkTouches::pattern() const {
  Hash hash;
  for (const LinkTouch& at : touches_) {
    hash.word(std::uint64_t(at.link)).word(std::uint64_t(at.obstacle));
    hash.word(static_cast<std::uint64_t>(at.spot));
    hash.word(static_cast<std::uint64_t>(at.touch.state));
  }
  return hash.value();
}

}  // namespace taut::direct
