// The second stage of a step of bodies at obstacles: velocities.
#include <algorithm>

#include "sim/methods/direct/contact/body_touches.h"
#include "sim/motion/hash.h"

namespace taut::direct {
namespace {

using contact::Vec6;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kShortOf = 100;  // times touching: a hit that was located is this near

}  // namespace

/// Tells a touch of the second stage where it is.
void BodyTouches::aim_velocity(const Step& step, const contact::Capsule& own, std::size_t touch,
                               const std::vector<double>& next) {
  contact::BodyTouch& at = touches_[touch];
  const FrameMotion& end = step.end[at.obstacle];
  const contact::SpotGap near =
      contact::gap_at(step.obstacles[at.obstacle].shape, end.pose(), own, at.spot);
  const Vec3 there = own.at(near.along) - own.radius * near.normal;
  at.arm = there - ConstMap(&next[step.mechanism.pose(at.body)]);
  at.touch.normal = near.normal;
  at.touch.surface = end.point(end.rotation.conjugate() * (there - end.position)).velocity;
  at.touch.least = near.normal.dot(at.touch.surface);
  places_[touch].before = at.given;
}

/// How fast (m/s) a body comes to what it hits, of which `own` is the work of the touch itself.
/// Links may pull it there for the rest of a step in which it has been stopped: that is no speed of
/// its own, and a bounce of it would be work from nowhere.
double BodyTouches::arriving(const Step& step, std::size_t touch, const Vec3& own,
                             const std::vector<double>& next) const {
  const contact::BodyTouch& at = touches_[touch];
  const std::size_t u = step.mechanism.twist(at.body);
  const auto coming = [&](const Vec3& velocity) {
    return at.touch.least - at.touch.normal.dot(velocity);
  };
  const Vec3 moves = contact::velocity_at(twist_at(&next[u]), at.arm);
  const double pulled = coming(moves - own);
  if (!(at.touch.push > 0)) return pulled;
  const Vec3 falls =
      contact::velocity_at(twist_at(&step.state[u]), at.arm) + step.h * step.mechanism.gravity();
  return std::min(pulled, std::max(coming(moves), coming(falls)));
}

void BodyTouches::aim_velocities(const Step& step, const std::vector<double>& next, double least) {
  const Mechanism& mechanism = step.mechanism;
  for (std::size_t i = touches_.size(); i-- > 0;) {
    if (places_[i].gap <= (places_[i].hits ? kShortOf : 1) * step.touching) continue;
    touches_.erase(touches_.begin() + static_cast<std::ptrdiff_t>(i));
    places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  each_body([&](std::size_t b, std::size_t first, std::size_t count) {
    const contact::Capsule own = capsule(&next[mechanism.pose(b)], b);
    for (std::size_t i = first; i < first + count; ++i) aim_velocity(step, own, i, next);
    const auto& body = mechanism.bodies()[b];
    const std::span touches(&touches_[first], count);
    system_.assemble(contact::mobility(body.inverse_mass, body.world_inverse), touches);
    for (std::size_t i = 0; i < count; ++i) {
      if (!places_[first + i].hits) continue;
      const Vec3 by_itself = system_.coupling(i, i) * touches[i].given;
      const double bounce = step.obstacles[touches[i].obstacle].restitution *
                            arriving(step, first + i, by_itself, next);
      if (bounce > least) touches[i].touch.least += bounce;
    }
  });
}

bool BodyTouches::settle(const Mechanism& mechanism, const std::vector<double>& next,
                         double creep) {
  for (std::size_t b = 0; b < answers_.size(); ++b) {
    const auto& body = mechanism.bodies()[b];
    answers_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
    twists_[b].setZero();
  }
  bool finds = true;
  each_body([&](std::size_t b, std::size_t first, std::size_t count) {
    const std::span touches(&touches_[first], count);
    system_.assemble(answers_[b], touches);
    const Vec6 twist = twist_at(&next[mechanism.twist(b)]);
    bare_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      Vec3 moves = contact::velocity_at(twist, touches[i].arm);
      for (std::size_t k = 0; k < count; ++k) {
        moves -= system_.coupling(i, k) * places_[first + k].before;
      }
      bare_.push_back(moves);
    }
    finds = system_.solve(bare_, touches, creep) && finds;
    // Signorini and Coulomb hold for the sum of both stages, of which the first is in the twist.
    twists_[b] = system_.twist(touches);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& before = places_[first + i].before;
      Vec6 wrench;
      wrench << before, touches[i].arm.cross(before);
      twists_[b] -= answers_[b] * wrench;
    }
    if (!mechanism.rows().empty()) answers_[b] = system_.answer(touches);
  });
  return finds;
}

std::uint64_t BodyTouches::pattern() const {
  Hash hash;
  for (const contact::BodyTouch& at : touches_) {
    hash.word(std::uint64_t(at.body)).word(std::uint64_t(at.obstacle));
    hash.word(static_cast<std::uint64_t>(at.spot));
    hash.word(static_cast<std::uint64_t>(at.touch.state));
  }
  return hash.value();
}

}  // namespace taut::direct
