// Where head and eyes look.
#include <algorithm>
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

// m, for a figure of 1.78 m
const Vec3 opponent(0.35, 1.55, 3.0);
const Vec3 audience(-1.35, 1.42, 2.1);     // whom he greets
constexpr double stick_end = 0.15;         // m along the stick from the grip
constexpr double low = 1.10, high = 1.40;  // m, of the hand: how much of the gaze it draws
constexpr double least_drawn = 0.25, most_drawn = 0.8;
const Vec3 before_him(0.2, 0.55, 1.9);                   // m, where he looks at first
constexpr double looks_up = 0.25, takes_to_look = 0.40;  // s
// Before all rests (s) the stick goes behind him; after it he still looks there, over the shoulder.
constexpr double behind_by = 0.13, goes_behind = 0.14, looks_after = 0.18;
constexpr double over_shoulder = 0.05;  // m, of what he looks at there over the chain's end
constexpr double followed_smoothly = 0.05, lead = 0.12;  // s: 0.08 s ahead once the eyes are there
constexpr double head_share = 0.78;  // of the way from the chest's front to the target
constexpr double level = 0.85;       // the share of the trunk's tilt that the head makes up for
constexpr double leans_away = 0.16;  // rad, of the head from a stick that flies past it
constexpr double head_lag = 0.088, eye_lag = 0.040;  // s
constexpr double most_yaw = 0.60;                    // rad, of an eye
constexpr double most_lean = 0.42;  // rad: farther down the lower lid hides the iris
constexpr double most_nod = 0.80;   // rad, of the head
constexpr double blink_every = 2.9, blink_lasts = 0.20;  // s
constexpr double first_blink = 2.3;                      // s

/// Yaw to the left and lean forward (rad) of a direction.
Eigen::Vector2d angles(const Vec3& direction) {
  return {std::atan2(direction.x(), direction.z()),
          std::atan2(-direction.y(), std::hypot(direction.x(), direction.z()))};
}

/// How far the lids are down: they fall faster than they rise, at uneven intervals.
double blink(double time) {
  const double k = std::floor((time - first_blink) / blink_every);
  constexpr double golden = 0.6180339887;
  const double start = blink_every * k + first_blink + 0.6 * std::fmod(k * golden, 1.0);
  const double t = (time - start) / blink_lasts;
  return t < 0.4 ? smoothstep(t / 0.33) * (t > 0 ? 1 : 0) : smoothstep((1 - t) / 0.6);
}

}  // namespace

void look_about(const Figure& figure, const Path& path, Track& controls, const Cues& cues) {
  const double scale = figure.scale();
  const auto gaze = [&](double t) -> Vec3 {
    const Pose held = path.at(t).pose();
    const double drawn =
        least_drawn +
        (most_drawn - least_drawn) * smoothstep((held.position.y() / scale - low) / (high - low));
    const Vec3 end = held.position + held.rotation * Vec3(0, stick_end, 0);
    const Vec3 front = scale * opponent;
    if (!cues.swings) return front + drawn * (end - front);
    // He looks up from the floor to the opponent, then to the stick, and over his shoulder once
    // it is behind him; in the end to whom he greets, and lets no bow take his eyes off them.
    const Vec3 floor = scale * before_him;
    Vec3 waits = floor + smoothstep((t - looks_up) / takes_to_look) * (front - floor);
    if (cues.greets() && t > cues.rests) waits = scale * audience;
    const double follows =
        smoothstep((t - cues.begins + takes_to_look) / takes_to_look) *
        smoothstep((cues.rests + looks_after + takes_to_look - t) / takes_to_look);
    const Vec3 stick = cues.stick.at(t);
    const double behind = smoothstep((t - cues.rests + behind_by) / goes_behind);
    const Vec3 shoulder = end + scale * over_shoulder * Vec3::UnitY();
    return waits + follows * (stick + behind * (shoulder - stick) - waits);
  };
  const Track target = Track::sample(controls.time(controls.count() - 1), acting_rate,
                                     [&](double t) { return Eigen::VectorXd(gaze(t)); })
                           .smoothed(cues.swings ? followed_smoothly : 0.001)
                           .ahead(cues.swings ? lead : 0);
  const Track seen_late = target.lagged(head_lag), seen = target.lagged(eye_lag);
  const auto eyes_at = [&](const Placement& p) -> Vec3 {
    return p.position[figure.head_bone()] + p.turn[figure.head_bone()] * figure.between_eyes();
  };
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    Controls c = controls[i];
    const Placement torso = figure.skeleton().place(figure.torso(c));
    const Quat& chest = figure.chest_turn(torso);
    const Eigen::Vector2d head =
        head_share * angles(chest.conjugate() * (seen_late[i] - eyes_at(torso)));
    c[head_yaw] += soft(head[0], 1.1);
    c[head_lean] += soft(head[1], most_nod);
    const double passes = cues.passes(controls.time(i)), away = leans_away * passes;
    c[head_tilt] = -level * (c[spine_tilt] + c[pelvis_tilt]) - away;
    c[head_lean] -= away;
    const Placement turned = figure.skeleton().place(figure.torso(c));
    const Quat& front = turned.turn[figure.head_bone()];
    const Eigen::Vector2d eye = angles(front.conjugate() * (seen[i] - eyes_at(turned)));
    c[eye_yaw] = soft(eye[0], most_yaw);
    // He looks over what flies past: eyes that look down take their lids along.
    c[eye_lean] = soft(eye[1] - passes * std::max(eye[1], 0.0), most_lean);
    // Nobody blinks at whom he greets.
    const bool greets = cues.greets() && controls.time(i) > cues.rests;
    c[lids] = greets ? 0 : blink(controls.time(i));
    controls.samples().col(i) = c;
  }
}

}  // namespace taut::scenes
