#include "scenes/character/closed_hand.h"

#include <cmath>

#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

/// How far the outer phalanges' skin is from a neighbour's.
double gap_beside(const Digit& finger, const DigitTurns& turns, std::span<const Capsule> neighbour,
                  BentSkin& bent) {
  finger.bend(turns, bent);
  return std::min(gap(bent, 1, neighbour), gap(bent, 2, neighbour));
}

}  // namespace

DigitTurns chained(const Quat& a, const Quat& b, const Quat& c) {
  return {a, a * b, a * b * c};
}

DigitTurns flexed(const Flexion& flexion, const HandAxes& axes) {
  const Vec3 hinge = axes.along.cross(axes.palm);
  const auto turn = [&](double angle) { return Quat(Eigen::AngleAxisd(angle, hinge)); };
  const auto [a, b, c] = flexion.joints;
  DigitTurns turns = chained(turn(a), turn(b), turn(c));
  if (flexion.aside == 0) return turns;
  const Quat lean(Eigen::AngleAxisd(flexion.aside, axes.along.cross(axes.across)));
  for (Quat& q : turns) q = q * lean;
  return turns;
}

void add_turns(const Digit& digit, const DigitTurns& turns, FingerTurns& fingers) {
  for (std::size_t k = 0; k < 3; ++k)
    fingers.emplace_back(digit.bones()[k], k == 0 ? turns[0] : turns[k - 1].conjugate() * turns[k]);
}

std::array<Capsule, 3> phalanges_of(const Digit& finger, const DigitTurns& turns) {
  const auto at = finger.joints(turns);
  std::array<Capsule, 3> phalanges;
  for (std::size_t k = 0; k < 3; ++k)
    phalanges[k] = {at[k], at[k + 1], finger.radius(k), finger.bones()[k]};
  return phalanges;
}

void add_finger(const Digit& finger, const DigitTurns& turns, ClosedHand& closed) {
  add_turns(finger, turns, closed.fingers);
  const auto phalanges = phalanges_of(finger, turns);
  closed.phalanges.insert(closed.phalanges.end(), phalanges.begin(), phalanges.end());
}

ClosedHand close_side_by_side(
    std::span<const Digit> fingers, const HandAxes& axes,
    const std::function<DigitTurns(std::size_t finger, double aside)>& close) {
  constexpr std::size_t middle = 1;
  constexpr double most = 24 * degree, finest = 0.1 * degree;
  std::array<DigitTurns, finger_names.size()> turns;
  turns[middle] = close(middle, 0);
  BentSkin bent;
  // The middle finger's neighbours, then theirs.
  for (const auto& [finger, neighbour] : {std::pair{0, 1}, {2, 1}, {3, 2}}) {
    const auto i = static_cast<std::size_t>(finger), beside = static_cast<std::size_t>(neighbour);
    const auto phalanges = phalanges_of(fingers[beside], turns[beside]);
    const double side =
        (fingers[beside].rest(0) - fingers[i].rest(0)).dot(axes.across) > 0 ? 1 : -1;
    constexpr double flesh = 0.6 * mm;  // that gives way where fingers press on one another
    double apart = 0, pressed = most;
    while (pressed - apart > finest) {
      const double trial = (apart + pressed) / 2;
      turns[i] = close(i, side * trial);
      (gap_beside(fingers[i], turns[i], phalanges, bent) > -flesh ? apart : pressed) = trial;
    }
    turns[i] = close(i, side * apart);
  }
  ClosedHand closed;
  for (std::size_t i = 0; i < fingers.size(); ++i) add_finger(fingers[i], turns[i], closed);
  return closed;
}

}  // namespace taut::scenes
