// The body's part in a hand's path: weight, torso, shoulders and head that prepare, follow through
// and breathe. All of it follows from the path; nothing is keyed by hand.
#pragma once

#include "scenes/character/figure.h"
#include "scenes/character/track.h"
#include "sim/motion/path.h"

namespace taut::scenes {

/// Samples a second of everything that is worked out beforehand.
constexpr double acting_rate = 120;

/// Controls over [0, duration] (s); those of head, eyes and right arm are left zero.
Track act(const Figure& figure, const Path& path, double duration);

/// Turns head and eyes: to the opponent straight ahead, and to the stick the more the higher the
/// hand goes. The eyes are there first, the head comes after; now and then the lids blink.
void look_about(const Figure& figure, const Path& path, Track& controls);

/// The face: calm before anything has happened, concentrated while the hand moves, strained where
/// it is thrown about, and pleased once all is over.
void play_face(const Figure& figure, const Path& path, Track& controls);

/// Steps of the right and the left foot (3 rows each, m): where the hand settles farther forward or
/// aside, the right foot goes along beforehand, lifted, and stands again; then the left is drawn
/// up.
Track take_steps(const Track& hand);

/// Fills in the right arm's roll and swivel: at every instant those that bend the wrist least, keep
/// elbow, forearm and shoulder in their range and move smoothly; and shifts the pelvis where the
/// arm would be too short.
void plan_arm(const Figure& figure, const Path& path, Track& controls);

}  // namespace taut::scenes
