#include "scenes/character/grip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "scenes/character/closed_hand.h"
#include "scenes/character/soft.h"
#include "scenes/character/thumb.h"

namespace taut::scenes {
namespace {

/// How a finger that leans so far aside wraps round the stick: all phalanges touch it, as far as
/// joints allow.
Flexion wrap(const Digit& finger, double aside, const Capsule& stick, const HandAxes& axes) {
  using Angles = std::array<double, 3>;
  constexpr Angles most = {88 * degree, 108 * degree, 75 * degree};
  Angles best{};
  BentSkin bent;
  double least = std::numeric_limits<double>::infinity();
  for (const double knuckle : {50 * degree, 65 * degree, 80 * degree}) {
    for (const double middle : {25 * degree, 55 * degree, 90 * degree}) {
      Angles angles = {knuckle, middle, 35 * degree};
      const double cost = descend(angles, [&](const Angles& x, double enough) {
        finger.bend(flexed({x, aside}, axes), bent);
        double sum = 0;
        for (std::size_t k = 0; k < 3 && sum < enough; ++k)
          sum += touch(gap(bent, k, {&stick, 1})) +
                 1e4 * squared(beyond(x[k], most[k]) + beyond(5 * degree, x[k]));
        return sum;
      });
      if (cost < least) {
        least = cost;
        best = angles;
      }
    }
  }
  return {best, aside};
}

/// Where a stick's axis passes index and little finger's roots: along the hand and over its bones,
/// m.
using Place = std::array<double, 4>;

/// The stick lies where the fingers begin, across the palm, so far over the bones that
/// the skin touches it.
ClosedHand close_hand(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 wrist = skeleton.rest(hand);
  const HandAxes axes = hand_axes(skeleton, side);
  const double length = (skeleton.rest(skeleton.find(hand_name(side) + "Middle1")) - wrist).norm();
  std::vector<Digit> fingers;
  for (const char* name : finger_names) fingers.emplace_back(model, skeleton, side, name);

  const double index = (fingers.front().rest(0) - wrist).dot(axes.across);
  const double little = (fingers.back().rest(0) - wrist).dot(axes.across);
  const auto stick_at = [&](const Place& x) {
    const Vec3 a = wrist + x[0] * axes.along + index * axes.across + x[1] * axes.palm;
    const Vec3 b = wrist + x[2] * axes.along + little * axes.across + x[3] * axes.palm;
    const Vec3 axis = (a - b).normalized();
    const Vec3 centre = a - index / axis.dot(axes.across) * axis;
    return Capsule{centre - axis, centre + axis, radius, hand};
  };
  const Palm palm(model, skeleton, hand);
  // Nearer the wrist, knuckles would have to fold too far. At the thumb it is nearer to the
  // fingertips, as a fist holds a rod.
  constexpr double ahead = 0.825, behind = 0.65;
  const Place best = {ahead * length, radius + 0.18 * length, behind * length,
                      radius + 0.18 * length};
  Place x = best;
  ClosedHand closed;
  // Fingers that close pull the palm's skin along, so that the stick lies a little differently.
  for (int round = 0;; ++round) {
    closed = {{}, {}, stick_at(x)};
    for (const Digit& finger : fingers)
      add_finger(finger, flexed(wrap(finger, 0, closed.stick, axes), axes), closed);
    const std::vector<Vec3> points = palm.bent(closed.fingers);
    if (round == 3 || points.empty()) break;
    const auto cost = [&](const Place& trial, double) {
      const Capsule stick = stick_at(trial);
      const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
      std::vector<double> places;
      for (const Digit& finger : fingers) places.push_back((finger.rest(0) - centre).dot(axis));
      double sum = squared((trial[0] - best[0]) / mm) + squared((trial[2] - best[2]) / mm);
      for (const double gap : gaps_along(points, stick, places))
        if (std::isfinite(gap)) sum += touch(gap);
      return sum;
    };
    descend(x, cost, 10 * mm, 0.1 * mm);
  }
  const Capsule stick = closed.stick;
  closed = close_side_by_side(fingers, axes, [&](std::size_t i, double aside) {
    return flexed(wrap(fingers[i], aside, stick, axes), axes);
  });
  closed.stick = stick;
  return closed;
}

}  // namespace

Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const HandAxes axes = hand_axes(skeleton, side);
  ClosedHand closed = close_hand(model, skeleton, side, radius);
  const Capsule& stick = closed.stick;
  const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // The thumb goes round from the other side, on the side of the chain, and over the end of the
  // index finger: towards its middle phalanx, as far as it reaches.
  constexpr double beside = 14 * mm, back = 0.2;
  const Capsule& end = closed.phalanges[2];
  const Vec3 over = (1 - back) * end.a + back * closed.phalanges[1].a + beside * axis;
  const Vec3 off = over - centre;
  const Vec3 out = (off - off.dot(axis) * axis).normalized();
  const Vec3 tip = over + 0.6 * (end.radius + thumb.digit().radius(2)) * out;  // close beside it
  std::vector<Capsule> things = closed.phalanges;
  things.push_back(stick);
  const std::array<Capsule, 3> wanted = {stick, closed.phalanges[1], end};
  add_turns(thumb.digit(), thumb.lay(wanted, things, tip), closed.fingers);
  return {centre - skeleton.rest(stick.bone), axis, std::move(closed.fingers)};
}

}  // namespace taut::scenes
