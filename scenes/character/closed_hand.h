// Fingers that close: how they turn, and how they come to lie side by side.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "scenes/character/hand_axes.h"
#include "scenes/character/palm.h"
#include "scenes/character/touch.h"

namespace taut::scenes {

inline constexpr std::array<const char*, 4> finger_names = {"Index", "Middle", "Ring", "Pinky"};

/// How far a finger's joints are flexed, and how far it leans to the side of the thumb; rad.
struct Flexion {
  std::array<double, 3> joints{};
  double aside = 0;
};

/// Fingers closed round a stick that lies in the palm, or round nothing.
struct ClosedHand {
  FingerTurns fingers;
  std::vector<Capsule> phalanges;  // three a finger, in the order of finger_names
  Capsule stick;                   // longer than any hand is wide
};

/// A digit's turns from those of each joint against the one before.
DigitTurns chained(const Quat& a, const Quat& b, const Quat& c);

/// A finger flexes toward the palm, about the line across it: as far as it leans aside, all of its
/// phalanges do, so that fingers that are closed side by side stay so.
DigitTurns flexed(const Flexion& flexion, const HandAxes& axes);

void add_turns(const Digit& digit, const DigitTurns& turns, FingerTurns& fingers);
/// Its phalanges where those turns bring them.
std::array<Capsule, 3> phalanges_of(const Digit& finger, const DigitTurns& turns);
void add_finger(const Digit& finger, const DigitTurns& turns, ClosedHand& closed);

/// Closes the fingers, in the order of finger_names, each beside the next one nearer to the middle
/// finger until their skins touch. `close` turns a finger that leans so far aside.
ClosedHand close_side_by_side(
    std::span<const Digit> fingers, const HandAxes& axes,
    const std::function<DigitTurns(std::size_t finger, double aside)>& close);

}  // namespace taut::scenes
