// One touch of bodies, where all others give what they do.
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "sim/contact/body_system.h"

namespace taut::contact {
namespace {

constexpr double kClosed = 1e-13;  // of the speeds: less is no approach but rounding
constexpr int kTurns = 20;         // of Newton's method on the way of sliding
constexpr int kWays = 32;          // looked at where that fails
constexpr int kHalvings = 60;

}  // namespace

/// One touch alone, where the others give what they do. False: friction jams it.
bool BodySystem::solve_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const double short_of = touch.least - n.dot(bare);
  if (!(short_of > kClosed * (1 + bare.norm()))) {
    set(at, Touch::State::open, Vec3::Zero());
    return true;
  }
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  if (touch.stick == 0 && touch.slide == 0) {
    set(at, Touch::State::slides, short_of / n.dot(mobility * n) * n);
    return true;
  }
  if (at.ahead.isZero(0)) {
    const Mat3 tangent = across(n);
    const Vec3 slip = tangent * (bare - touch.surface);
    const Mat3 creeps = mobility + creep_ * inverse_mass_[i] * tangent;
    const Vec3 given = creeps.partialPivLu().solve(short_of * n - slip);
    const double push = n.dot(given);
    if (push > 0 && (given - push * n).norm() <= friction_of(touch, slip) * push) {
      set(at, Touch::State::sticks, given);
      return true;
    }
  }
  return slide_one(i, bare, at);
}

/// The way of sliding under which friction is against it: a root of one angle.
bool BodySystem::slide_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  const double short_of = touch.least - n.dot(bare);
  const auto given = [&](const Vec3& way) -> Vec3 {
    const Vec3 force = n - touch.slide * way;
    const double gives = n.dot(mobility * force);
    return gives > 0 ? Vec3(short_of / gives * force) : Vec3(Vec3::Zero());
  };
  const auto slip = [&](const Vec3& way) -> Vec3 {
    return across(n) * (bare + mobility * given(way) - touch.surface);
  };
  if (!at.ahead.isZero(0)) {
    set(at, Touch::State::slides, given(at.ahead));
    return touch.push > 0;
  }
  Vec3 first = across(n) * (bare - touch.surface);
  if (!(first.norm() > 0)) first = touch.sliding - n.dot(touch.sliding) * n;
  if (!(first.norm() > 0)) first = n.unitOrthogonal();
  first.normalize();
  const Vec3 aside = n.cross(first);
  Vec3 way = first;
  for (int turn = 0; turn < kTurns; ++turn) {  // mostly a contraction
    const Vec3 goes = slip(way);
    const double speed = goes.norm();
    if (!(speed > 0) || !(way.dot(goes) > 0)) break;
    const Vec3 next = goes / speed;
    const double moved = (next - way).norm();
    way = next;
    if (moved > 1e-15) continue;
    set(at, Touch::State::slides, given(way));
    return touch.push > 0;
  }
  const auto towards = [&](double angle) -> Vec3 {
    return std::cos(angle) * first + std::sin(angle) * aside;
  };
  const auto off = [&](double angle) {
    return slip(towards(angle)).dot(towards(angle + std::numbers::pi / 2));
  };
  constexpr double kStep = 2 * std::numbers::pi / kWays;
  for (int k = 0; k < kWays; ++k) {
    double low = (k - 0.5) * kStep, high = low + kStep;
    const double at_low = off(low);
    if (at_low * off(high) > 0) continue;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = (low + high) / 2;
      (at_low * off(middle) > 0 ? low : high) = middle;
    }
    way = towards((low + high) / 2);
    const Vec3 found = given(way);
    if (!(n.dot(found) > 0) || !(slip(way).dot(way) >= 0)) continue;
    set(at, Touch::State::slides, found);
    return true;
  }
  return false;
}

}  // namespace taut::contact
