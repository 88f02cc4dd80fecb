// What the acting goes by beside the path of the hand, known before the simulation runs.
#pragma once

#include <limits>
#include <optional>

#include "scenes/character/track.h"
#include "sim/motion/path.h"

namespace taut::scenes {

/// Samples a second of everything that is worked out beforehand.
constexpr double acting_rate = 120;

/// A stick that hangs by a chain from the one in the hand.
struct FreeStick {
  Vec3 from = Vec3::Zero();                   // m, from the grip's centre, in the path's frame
  double chain = 0, chain_mass = 0;           // m, kg
  double mass = 0, length = 0, diameter = 0;  // kg, m
};

/// When the hand moves, and where the free stick will be. Without more, he has taken his stance and
/// nothing hangs from his stick.
struct Cues {
  static constexpr double kNever = -std::numeric_limits<double>::infinity();
  double begins = kNever, rests = kNever, ends = kNever;  // s: the hand moves, rests; all is over
  bool swings = false;                                    // whether a stick hangs from the hand's
  /// The free stick's centre while nothing stops it, m.
  Track stick = Track(Eigen::MatrixXd::Zero(3, 1), 1);
  /// The same from where it hangs at rest, while he plays.
  Track off = Track(Eigen::MatrixXd::Zero(3, 1), 1);
  /// From 0 to 1: the stick is fast, or will be at once; a stroke of the hand comes.
  Track braced = Track(Eigen::MatrixXd::Zero(1, 1), 1), winds_up = braced;

  /// From 0 to 1: he waits, then has taken his stance.
  double ready(double time) const;
  /// From 0 to 1 and back: he plays, and has come to rest again.
  double plays(double time) const;
  /// From 0 to 1: the last stroke is made.
  double struck(double time) const;
  /// From 0 to 1 and back: the stick flies past his head.
  double passes(double time) const;
  /// From 0 to 1: he stands up when all is over.
  double rises(double time) const;
  /// Whether he stands long enough at the end to greet.
  bool greets() const;
  /// From 0 to 1 and back: his bow.
  double nod(double time) const;
};

/// The free stick swings as the chain leads it: a simulation that meets nothing tells where it goes
/// until it strikes him.
Cues foresee(const Path& hand, const std::optional<FreeStick>& stick, double duration);

}  // namespace taut::scenes
