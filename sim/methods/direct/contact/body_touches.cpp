#include "sim/methods/direct/contact/body_touches.h"

#include <algorithm>
#include <cmath>
namespace taut::direct {
namespace {

using contact::Mat6;
using contact::Spot;
using contact::SpotGap;
using contact::Vec6;
using ConstMap = Eigen::Map<const Vec3>;
using State = contact::Touch::State;

/// The motion of an obstacle's material at a place.
PointMotion surface(const FrameMotion& frame, const Vec3& at) {
  return frame.point(frame.rotation.conjugate() * (at - frame.position));
}

}  // namespace

void BodyTouches::rebuild(const World& world) {
  capsules_.clear();
  reach_.clear();
  possible_ = false;
  for (const Body& body : world.bodies) {
    if (body.driven()) continue;
    BodyCapsule capsule = body.capsule;
    capsule.from -= body.mass_properties.centre;
    capsule.to -= body.mass_properties.centre;
    capsules_.push_back(capsule);
    const double far = std::max(capsule.from.norm(), capsule.to.norm()) + capsule.radius;
    reach_.push_back(capsule.touches() ? far : 0);
    possible_ = possible_ || capsule.touches();
  }
  touches_.clear();
  before_.clear();
  places_.clear();
  answers_.resize(capsules_.size());
  twists_.assign(capsules_.size(), Vec6::Zero());
}

contact::Capsule BodyTouches::capsule(const double* pose, std::size_t body) const {
  const BodyCapsule& own = capsules_[body];
  const Quat rotation = quaternion(pose + 3).normalized();
  const Vec3 centre = ConstMap(pose);
  return {centre + rotation * own.from, centre + rotation * own.to, own.radius};
}

bool BodyTouches::is_known(std::uint32_t body, std::uint32_t obstacle, std::size_t spot) const {
  return std::ranges::any_of(touches_, [&](const contact::BodyTouch& at) {
    return at.body == body && at.obstacle == obstacle && static_cast<std::size_t>(at.spot) == spot;
  });
}

void BodyTouches::find(const Step& step) {
  before_.swap(touches_);
  touches_.clear();
  places_.clear();
  for (std::uint32_t b = 0; b < capsules_.size(); ++b) {
    if (!capsules_[b].touches()) continue;
    const double* pose = &step.state[step.mechanism.pose(b)];
    const contact::Capsule own = capsule(pose, b);
    const Vec6 twist = twist_at(&step.state[step.mechanism.twist(b)]);
    for (std::uint32_t o = 0; o < step.obstacles.size(); ++o) {
      if (!step.obstacles[o].touches(capsules_[b].category)) continue;
      const Shape& shape = step.obstacles[o].shape;
      const Pose frame = step.start[o].pose();
      if (contact::gap_at(shape, frame, own, 0.5).distance > (own.to - own.from).norm()) continue;
      const auto gaps = contact::all_gaps(shape, frame, own);
      for (const Spot spot : contact::kSpots) {
        const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
        if (!near.distinct || near.distance > step.touching) continue;
        const Vec3 at = own.at(near.along) - own.radius * near.normal;
        const Vec3 passing =
            contact::velocity_at(twist, at - ConstMap(pose)) - surface(step.start[o], at).velocity;
        if (near.normal.dot(passing) > step.touching) continue;
        add(step, b, o, spot, false);
      }
    }
  }
}

void BodyTouches::add(const Step& step, const Hit& hit) {
  for (const Spot spot : contact::kSpots) {
    const auto index = static_cast<std::size_t>(spot);
    if (!(hit.spots & (1u << index)) || is_known(hit.body, hit.obstacle, index)) continue;
    add(step, hit.body, hit.obstacle, spot, true);
  }
}

/// Adds a touch behind those of its body and of the ones before.
void BodyTouches::add(const Step& step, std::uint32_t body, std::uint32_t obstacle, Spot spot,
                      bool hits) {
  const double* pose = &step.state[step.mechanism.pose(body)];
  const contact::Capsule own = capsule(pose, body);
  const SpotGap near =
      contact::gap_at(step.obstacles[obstacle].shape, step.start[obstacle].pose(), own, spot);
  contact::BodyTouch made{.body = body, .obstacle = obstacle, .spot = spot, .touch = {}};
  Place place{.hits = hits, .along_start = near.along, .start_normal = near.normal};
  made.touch.stick = step.obstacles[obstacle].static_friction;
  made.touch.slide = step.obstacles[obstacle].kinetic_friction;
  const bool stuck = std::ranges::any_of(before_, [&](const contact::BodyTouch& was) {
    return was.body == body && was.obstacle == obstacle && was.spot == spot &&
           was.touch.state == State::sticks;
  });
  if (!stuck) {
    const Vec3 at = own.at(near.along) - own.radius * near.normal;
    const Vec6 twist = twist_at(&step.state[step.mechanism.twist(body)]);
    made.touch.slid = contact::velocity_at(twist, at - ConstMap(pose)) -
                      surface(step.start[obstacle], at).velocity;
  }
  const auto behind = std::ranges::upper_bound(touches_, body, {}, &contact::BodyTouch::body);
  places_.insert(places_.begin() + (behind - touches_.begin()), place);
  touches_.insert(behind, made);
}

void BodyTouches::rub(const std::vector<Obstacle>& obstacles, double share) {
  for (contact::BodyTouch& at : touches_) {
    at.touch.stick = share * obstacles[at.obstacle].static_friction;
    at.touch.slide = share * obstacles[at.obstacle].kinetic_friction;
  }
}

void BodyTouches::release() {
  for (contact::BodyTouch& at : touches_) {
    at.given.setZero();
    at.touch.push = 0;
    at.touch.state = State::open;
  }
  for (Place& place : places_) place.before.setZero();
}

double BodyTouches::aim(const Step& step, const std::vector<double>& next) {
  double turned = 0;
  const Mechanism& mechanism = step.mechanism;
  aimed_.assign(next.begin() + static_cast<std::ptrdiff_t>(mechanism.pose(0)),
                next.begin() + static_cast<std::ptrdiff_t>(mechanism.pose(capsules_.size())));
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    contact::BodyTouch& at = touches_[i];
    Place& place = places_[i];
    const double *from = &step.state[mechanism.pose(at.body)], *to = &next[mechanism.pose(at.body)];
    const contact::Capsule own = capsule(to, at.body);
    const FrameMotion& end = step.end[at.obstacle];
    const SpotGap near =
        contact::gap_at(step.obstacles[at.obstacle].shape, end.pose(), own, at.spot);
    place.gap = near.distance;
    const BodyCapsule& local = capsules_[at.body];
    const auto on_axis = [&](double along) -> Vec3 {
      return local.from + along * (local.to - local.from);
    };
    place.at = on_axis(near.along);
    place.mean = place.hits ? place.at : on_axis((near.along + place.along_start) / 2);
    // Along the mean normal a body that stays at a round surface moves no way at all.
    Vec3 normal = near.normal;
    if (!place.hits) normal += place.start_normal;
    at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
    place.down = -own.radius * at.touch.normal;
    const Quat before = quaternion(from + 3), after = quaternion(to + 3);
    turned = std::max(turned, angle(after * before.conjugate()).norm());
    const Vec3 is = ConstMap(to) + after * place.at, was = ConstMap(from) + before * place.at;
    at.arm = (before * place.mean + after * place.mean) / 2 + place.down;
    const Vec3 there = is + place.down;
    const Vec3 carried = end.rotation.conjugate() * (there - end.position);
    at.touch.surface = (there - step.start[at.obstacle].pose().to_world(carried)) / step.h;
    at.touch.least = (at.touch.normal.dot(is - was) - near.distance) / step.h;
  }
  return turned;
}

bool BodyTouches::solve_means(const Step& step, std::span<const Mat3> inverse,
                              const std::vector<double>& next, double creep, double& change) {
  const Mechanism& mechanism = step.mechanism;
  for (std::size_t b = 0; b < answers_.size(); ++b) {
    answers_[b] = contact::mobility(mechanism.bodies()[b].inverse_mass, inverse[b]);
  }
  bool finds = true;
  each_body([&](std::size_t b, std::size_t first, std::size_t count) {
    const double *from = &step.state[mechanism.pose(b)], *to = &next[mechanism.pose(b)];
    const Quat before = quaternion(from + 3), after = quaternion(to + 3);
    const Vec3 spin = angle(after * before.conjugate()) / step.h;
    const std::span touches(&touches_[first], count);
    system_.assemble(answers_[b], touches, 0.5);
    const Vec6 given = 0.5 * system_.twist(touches);
    bare_.clear();
    std::vector<Vec3> last;
    double most = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Place& place = places_[first + i];
      const Vec3 way = ConstMap(to) + after * place.at - ConstMap(from) - before * place.at;
      bare_.push_back(way / step.h + spin.cross(place.down) -
                      contact::velocity_at(given, touches[i].arm));
      last.push_back(touches[i].given);
    }
    finds = system_.solve(bare_, touches, creep) && finds;
    double moved = 0;
    for (std::size_t i = 0; i < count; ++i) {
      most = std::max(most, touches[i].given.norm());
      moved = std::max(moved, (touches[i].given - last[i]).norm());
    }
    if (moved > 0) change = std::max(change, moved / std::max(most, moved));
    if (!mechanism.rows().empty()) answers_[b] = system_.answer(touches);
  });
  return finds;
}

void BodyTouches::kick(const Mechanism& mechanism, const std::vector<double>& poses,
                       std::span<const Mat3> inverse, std::vector<double>& twists) const {
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const std::size_t b = touches_[i].body;
    const Quat rotation = quaternion(&poses[mechanism.pose(b) + 3]);
    const Vec3 arm = rotation * places_[i].mean + places_[i].down;
    const Vec3 given = 0.5 * touches_[i].given;
    Eigen::Map<Vec6> u(&twists[mechanism.twist(b)]);
    u.head<3>() += mechanism.bodies()[b].inverse_mass * given;
    u.tail<3>() += inverse[b] * arm.cross(given);
  }
}

double BodyTouches::residual(const std::vector<double>& next, const Mechanism& mechanism) const {
  double worst = 0;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const std::size_t b = touches_[i].body;
    const double* aimed = &aimed_[7 * b];
    const double* is = &next[mechanism.pose(b)];
    const contact::Capsule a = capsule(aimed, b), c = capsule(is, b);
    const double gap = places_[i].gap;
    worst = std::max({worst, (a.from - c.from).lpNorm<Eigen::Infinity>(),
                      (a.to - c.to).lpNorm<Eigen::Infinity>(),
                      touches_[i].touch.push > 0 ? std::abs(gap) : -gap});
  }
  return worst;
}

}  // namespace taut::direct
