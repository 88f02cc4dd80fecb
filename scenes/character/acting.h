// The body's part in a hand's path: weight, torso, shoulders and head that prepare, follow through
// and breathe, and that answer the free stick. All of it follows from the path; nothing is keyed by
// hand.
#pragma once

#include <limits>
#include <optional>

#include "scenes/character/figure.h"
#include "scenes/character/track.h"
#include "sim/motion/path.h"

namespace taut::scenes {

// What the acting goes by beside the path of the hand, known before the simulation runs.

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

/// Controls over [0, duration] (s); those of head, eyes and right arm are left zero.
Track act(const Figure& figure, const Path& path, double duration, const Cues& cues = {});

/// Adds what the body does about the free stick: weight goes from foot to foot with it, hips turn
/// against shoulders, knees sink and rise, and he braces himself where it is fast. Before a stroke
/// of the hand he winds up, after it he recoils.
void answer_stick(const Figure& figure, const Cues& cues, Track& controls);

/// Fills in the left arm, which goes from guard to guard, and adds what its shoulder does.
void keep_guard(const Figure& figure, const Path& path, const Cues& cues, Track& controls);

/// Adds how he waits before he takes his stance, and how he greets in the end.
void begin_and_end(const Figure& figure, const Cues& cues, Track& controls);

/// Turns head and eyes: to the opponent straight ahead, and to the stick the more the higher the
/// hand goes; a free stick is followed while it is played, a little ahead of it. The eyes are there
/// first, the head comes after; now and then the lids blink.
void look_about(const Figure& figure, const Path& path, Track& controls, const Cues& cues = {});

/// The face: calm before anything has happened, concentrated while the hand moves, strained where
/// it is thrown about, and pleased once all is over. Eyes stay open for what passes the head.
void play_face(const Figure& figure, const Path& path, Track& controls, const Cues& cues = {});

/// Steps of the right and the left foot (3 rows each, m): where the hand settles farther forward or
/// aside, the right foot goes along beforehand, lifted, and stands again; then the left is drawn
/// up.
Track take_steps(const Track& hand);

/// Lowers the pelvis wherever a leg would be too short.
void sink_to_the_feet(const Figure& figure, Track& controls);

/// Fills in the right arm's roll and swivel: at every instant those that bend the wrist least, keep
/// elbow, forearm and shoulder in their range and move smoothly; and shifts the pelvis where the
/// arm would be too short.
void plan_arm(const Figure& figure, const Path& path, Track& controls);

}  // namespace taut::scenes
