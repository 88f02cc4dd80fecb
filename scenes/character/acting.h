// The body's part in a hand's path: weight, torso, shoulders and head that prepare, follow through
// and breathe, and that answer the free stick. All of it follows from the path; nothing is keyed by
// hand.
#pragma once

#include "scenes/character/cues.h"
#include "scenes/character/figure.h"
#include "scenes/character/track.h"
#include "sim/motion/path.h"

namespace taut::scenes {

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
