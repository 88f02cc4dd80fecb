#include "sim/contact/gauss_seidel.h"

#include <Eigen/LU>
#include <algorithm>

#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr int kMostSweeps = 50;
constexpr double kSettled = 1e-8;  // of what is given: a sweep that changes less is the last

/// The twist of a body under an impulse at a point of it.
Vec6 kick(const Mat6& mobility, const Vec3& arm, const Vec3& impulse) {
  Vec6 pull;
  pull << impulse, arm.cross(impulse);
  return mobility * pull;
}

void give(std::span<const Mat6> mobility, const BodyTouch& at, const Vec3& impulse,
          std::span<Vec6> twists) {
  twists[at.body] += kick(mobility[at.body], at.arm, impulse);
  if (at.other == kNoBody) return;
  twists[at.other] -= kick(mobility[at.other], at.other_arm, impulse);
}

/// The friction of a touch that has `before` and slips: what stops it, or else the cone's point
/// next to a step against the slip, so that it ends where both point opposite ways.
Vec3 friction_after(const Touch& touch, const EffectiveMass& mass, const Vec3& before,
                    const Vec3& slip, double push) {
  const double most = (touch.state == Touch::State::slides ? touch.slide : touch.stick) * push;
  const Vec3 stopping = before - mass.across * slip;
  if (stopping.norm() <= most) return stopping;
  const Vec3 against = before - mass.least_across * slip;
  return std::min(1.0, most / against.norm()) * against;
}

/// Goes through the touches until they change little.
void sweep(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (int i = 0; i < kMostSweeps; ++i) {
    check_stop();
    double most = 0, changed = 0;
    for (std::size_t t = 0; t < touches.size(); ++t) {
      BodyTouch& at = touches[t];
      const Vec3 &normal = at.touch.normal, before = at.given;
      const double pushed = normal.dot(before);
      const Vec3 rubbed = before - pushed * normal;
      const double missing = at.touch.least - normal.dot(passing(twists, at));
      const double push = std::max(0.0, pushed + masses[t].along * missing);
      give(mobility, at, (push - pushed) * normal, twists);

      const Vec3 slip = across(normal) * (passing(twists, at) - at.touch.surface);
      const Vec3 friction = friction_after(at.touch, masses[t], rubbed, slip, push);
      give(mobility, at, friction - rubbed, twists);
      at.given = push * normal + friction;
      most = std::max(most, at.given.norm());
      changed = std::max(changed, (at.given - before).norm());
    }
    if (changed <= kSettled * most) return;
  }
}

/// Whether a touch takes all that static friction gives.
bool slips(const BodyTouch& at) {
  const double push = at.touch.normal.dot(at.given);
  return (across(at.touch.normal) * at.given).norm() >= (1 - kSettled) * at.touch.stick * push;
}

}  // namespace

EffectiveMass effective_mass(std::span<const Mat6> mobilities, const BodyTouch& at) {
  Mat3 response = mobility(mobilities[at.body], at.arm, at.arm);  // 1/kg
  if (at.other != kNoBody) response += mobility(mobilities[at.other], at.other_arm, at.other_arm);
  const Vec3& normal = at.touch.normal;
  const Mat3 plane = across(normal), slip = plane * response * plane;
  const double along = normal.dot(response * normal);
  const Mat3 whole = slip + along * normal * normal.transpose();
  return {1 / along, plane * whole.inverse() * plane, 1 / slip.norm()};
}

void relax(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (BodyTouch& at : touches) at.touch.state = Touch::State::sticks;
  sweep(mobility, masses, touches, twists);
  bool slide = false;
  for (BodyTouch& at : touches) {
    if (at.touch.slide == at.touch.stick || !slips(at)) continue;
    at.touch.state = Touch::State::slides;
    slide = true;
  }
  if (slide) sweep(mobility, masses, touches, twists);
}

}  // namespace taut::contact
