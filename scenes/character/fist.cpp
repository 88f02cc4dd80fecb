#include "scenes/character/fist.h"

#include <cmath>
#include <limits>

#include "scenes/character/closed_hand.h"
#include "scenes/character/soft.h"
#include "scenes/character/thumb.h"

namespace taut::scenes {
namespace {

/// How far a finger is flexed whose joints turn together, as its tendons turn them.
Flexion curled(double share, double aside) {
  return {{share * 88 * degree, share * 116 * degree, share * 78 * degree}, aside};
}

/// The share at which the finger's end touches the palm's skin; a short finger's presses on it.
double curl(const Digit& finger, double aside, std::span<const Vec3> palm, const HandAxes& axes) {
  constexpr double least = 0.88, step = 0.005;
  constexpr double near = 1.5 * mm;  // half as far as vertices of the skin are from one another
  BentSkin bent;
  double share = least;
  for (; share + step <= 1; share += step) {
    finger.bend(flexed(curled(share + step, aside), axes), bent);
    double apart = std::numeric_limits<double>::infinity();
    for (const Vec3& p : bent.part(2))
      for (const Vec3& q : palm) apart = std::min(apart, (p - q).squaredNorm());
    if (apart < squared(near)) break;
  }
  return share;
}

}  // namespace

FingerTurns fist(const Model& model, const Skeleton& skeleton, Side side) {
  const HandAxes axes = hand_axes(skeleton, side);
  const Palm palm(model, skeleton, skeleton.find(hand_name(side)));
  std::vector<Digit> fingers;
  for (const char* name : finger_names) fingers.emplace_back(model, skeleton, side, name);
  std::array<double, finger_names.size()> share;
  share.fill(0.9);
  ClosedHand closed;
  // Fingers that close pull the palm's skin along, and lean aside.
  for (int round = 0;; ++round) {
    std::array<double, finger_names.size()> leaning{};
    closed = close_side_by_side(fingers, axes, [&](std::size_t i, double aside) {
      leaning[i] = aside;
      return flexed(curled(share[i], aside), axes);
    });
    if (round == 2) break;
    const std::vector<Vec3> skin = palm.bent(closed.fingers);
    for (std::size_t i = 0; i < fingers.size(); ++i)
      share[i] = curl(fingers[i], leaning[i], skin, axes);
  }
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // Across the middle phalanges of index and middle finger, as far as it reaches.
  const std::array<Capsule, 2> middles = {closed.phalanges[1], closed.phalanges[4]};
  const Vec3 across = middles[1].a - middles[0].a;
  // Nearer to the outer joint, so that the thumb crosses them.
  const Vec3 tip = middles[1].a + 0.9 * (middles[1].b - middles[1].a) + across / 2 +
                   (middles[1].radius + thumb.digit().radius(2)) * axes.palm;
  add_turns(thumb.digit(), thumb.lay(middles, closed.phalanges, tip), closed.fingers);
  return closed.fingers;
}

}  // namespace taut::scenes
