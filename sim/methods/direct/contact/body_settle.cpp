// The second stage of a step of bodies that touch something: velocities.
#include <algorithm>
#include <utility>

#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using contact::kNoBody;
using contact::Vec6;

constexpr double kShortOfTwo = 2000;  // the same of two bodies, both of whose ways are foretold

}  // namespace

/// Tells a touch of the second stage where it is.
void BodyTouches::aim_velocity(const Step& step, std::size_t touch,
                               const std::vector<double>& next) {
  contact::BodyTouch& at = touches_[touch];
  const contact::BodyMeeting& meeting = meetings_[at.meeting];
  const contact::Capsule own = capsule(&next[step.mechanism.pose(at.body)], at.body);
  const Pose place = solid(meeting, step.end, step.mechanism, next);
  const contact::SpotGap near = contact::gap_at(meeting.shape, place, own, at.spot);
  aim_arms(own, near, step.mechanism, next, at);
  at.touch.normal = near.normal;
  at.touch.surface.setZero();
  if (at.other == kNoBody) {
    const FrameMotion& end = step.end[meeting.obstacle];
    const Vec3 there = own.at(near.along) - own.radius * near.normal;
    at.touch.surface = end.point(end.rotation.conjugate() * (there - end.position)).velocity;
  }
  at.touch.least = near.normal.dot(at.touch.surface);
  places_[touch].before = at.given;
  if (at.other == kNoBody) return;
  // The push along the mean normal changes the direction of sliding: a new solve is due only along
  // this normal.
  const Vec3 friction = at.touch.friction;
  places_[touch].before = near.normal.dot(at.given - friction) * near.normal + friction;
}

/// How fast (m/s) a body comes to what it hits, of which `own` is the work of the touch itself.
/// Links may pull it there for the rest of a step in which it has been stopped: that is no speed of
/// its own, and a bounce of it would be work from nowhere.
double BodyTouches::arriving(const Step& step, std::size_t touch, const Vec3& own,
                             const std::vector<double>& next) const {
  const contact::BodyTouch& at = touches_[touch];
  const auto moves_in = [&](const std::vector<double>& state, const Vec3& gain) -> Vec3 {
    const auto of = [&](std::uint32_t body, const Vec3& arm) -> Vec3 {
      return contact::velocity_at(twist_at(&state[step.mechanism.twist(body)]), arm) + gain;
    };
    const Vec3 own_velocity = of(at.body, at.arm);
    return at.other == kNoBody ? own_velocity : Vec3(own_velocity - of(at.other, at.other_arm));
  };
  const auto coming = [&](const Vec3& velocity) {
    return at.touch.least - at.touch.normal.dot(velocity);
  };
  const Vec3 moves = moves_in(next, Vec3::Zero());
  const double pulled = coming(moves - own);
  if (!(at.touch.push > 0)) return pulled;
  const Vec3 falls = moves_in(step.state, step.h * step.mechanism.gravity());
  return std::min(pulled, std::max(coming(moves), coming(falls)));
}

void BodyTouches::aim_velocities(const Step& step, const std::vector<double>& next, double least) {
  const Mechanism& mechanism = step.mechanism;
  for (std::size_t i = touches_.size(); i-- > 0;) {
    const double short_of = touches_[i].other == kNoBody ? kShortOf : kShortOfTwo;
    if (places_[i].gap <= (places_[i].hits ? short_of : 1) * step.touching) continue;
    touches_.erase(touches_.begin() + static_cast<std::ptrdiff_t>(i));
    places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  gather();
  now_free(mechanism);
  clusters_.each(touches_, [&](std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) aim_velocity(step, i, next);
    const std::span touches(&touches_[first], count);
    system_.assemble(mobility_, touches);
    for (std::size_t i = 0; i < count; ++i) {
      if (!places_[first + i].hits) continue;
      const Vec3 by_itself = system_.coupling(i, i) * touches[i].given;
      const double bounce =
          meetings_[touches[i].meeting].restitution * arriving(step, first + i, by_itself, next);
      places_[first + i].bounce = bounce > least ? bounce : 0;
      touches[i].touch.least += places_[first + i].bounce;
    }
  });
}

bool BodyTouches::rebounds() const {
  return std::ranges::any_of(places_, [](const Place& place) { return place.bounce > 0; });
}

void BodyTouches::stop_bounces() {
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    touches_[i].touch.least -= std::exchange(places_[i].bounce, 0);
  }
}

/// How bodies respond by themselves, at the instant of the mechanism's last update.
void BodyTouches::now_free(const Mechanism& mechanism) {
  for (std::size_t b = 0; b < mobility_.size(); ++b) {
    const auto& body = mechanism.bodies()[b];
    mobility_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
  }
  coupled_.set_apart(mobility_);
}

bool BodyTouches::settle(const Mechanism& mechanism, const std::vector<double>& next,
                         double creep) {
  now_free(mechanism);
  for (std::size_t b = 0; b < twists_.size(); ++b) {
    moves_[b] = twist_at(&next[mechanism.twist(b)]);
    twists_[b].setZero();
  }
  bool finds = true;
  clusters_.each(touches_, [&](std::size_t first, std::size_t count) {
    const std::span touches(&touches_[first], count);
    system_.assemble(mobility_, touches);
    bare_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 moves = contact::passing(moves_, touches[i]);
      for (std::size_t k = 0; k < count; ++k) {
        moves -= system_.coupling(i, k) * places_[first + k].before;
      }
      bare_.push_back(moves);
    }
    finds = system_.solve(bare_, touches, creep) && finds;
    // Signorini and Coulomb hold for the sum of both stages, of which the first is in the twist.
    for (std::size_t k = 0; k < system_.bodies().size(); ++k) {
      twists_[system_.bodies()[k]] = system_.twist(touches, k);
    }
    const auto take_back = [&](std::uint32_t b, const Vec3& arm, const Vec3& before) {
      Vec6 wrench;
      wrench << before, arm.cross(before);
      twists_[b] -= mobility_[b] * wrench;
    };
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& before = places_[first + i].before;
      take_back(touches[i].body, touches[i].arm, before);
      if (touches[i].other != kNoBody) take_back(touches[i].other, touches[i].other_arm, -before);
    }
    if (!mechanism.rows().empty()) system_.couple(touches, coupled_);
  });
  return finds;
}

}  // namespace taut::direct
