// How the body answers the free stick and the strokes of the hand.
#include <algorithm>
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

constexpr double inertia = 0.11;  // s: what is faster the trunk does not follow
constexpr double weight_ahead = 0.12, hips_ahead = 0.05;   // s, of the stick
constexpr double chest_behind = 0.10, idle_behind = 0.06;  // s, mean delays
// Speeds of the stick (m/s) from which he braces himself, and at which he does entirely.
constexpr double brisk = 1.9, fast = 3.0;
constexpr double braced_by = 0.25, bracing = 0.22;  // s, before it is fast; and how smoothly
constexpr double windup = 0.26;                     // s, before the hand is fast
constexpr double stroke = 0.35;                     // m/s, by which it then is faster
/// Before the hand comes to rest for good the body is again where the path alone has it: what a
/// stick is thrown at must be there.
constexpr double done = 0.45, calms_down = 0.35;  // s

Track norms(Track rates) {
  rates.samples() = rates.samples().colwise().norm().eval();
  return rates;
}

}  // namespace

void answer_stick(const Figure& figure, const Path& path, const Cues& cues, Track& controls) {
  if (!cues.swings) return;
  const double scale = figure.scale();
  Track off = cues.stick;  // from where it hangs at rest, for a figure of 1.78 m
  const Vec3 hangs = off[0];
  for (Eigen::Index i = 0; i < off.count(); ++i)
    off.samples().col(i) = cues.plays(off.time(i)) / scale * (off[i] - hangs);
  const Track slow = off.smoothed(inertia);
  const Track weight = slow.ahead(weight_ahead), hips = slow.ahead(hips_ahead);
  const Track chest = slow.lagged(chest_behind), idle = off.smoothed(0.05).lagged(idle_behind);
  Track speed = norms(off.rates()).smoothed(0.25);
  for (double& v : speed.samples().reshaped()) v = smoothstep((v - brisk) / (fast - brisk));
  const Track braced = speed.smoothed(bracing).ahead(braced_by);

  const Track hand = Track::sample(controls.time(controls.count() - 1), acting_rate, [&](double t) {
    return Eigen::VectorXd(path.at(t).position / scale);
  });
  const Track haste = norms(hand.rates()).smoothed(0.10);
  const Track coming = haste.ahead(windup);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i);
    const double share = smoothstep((cues.rests - done - time) / calms_down);
    const Vec3 w = share * weight[i], h = share * hips[i], c = share * chest[i];
    const Vec3 left = share * idle[i];
    const double brace = share * braced[i][0], plays = share * cues.plays(time);
    // A stroke that comes, but not what goes on at one speed.
    const double before = smoothstep((cues.rests - time) / done - 0.5) *
                          soft(std::max(0.0, coming[i][0] - haste[i][0] - stroke), 1.0);
    auto u = controls.samples().col(i);
    // The feet stand one before the other: the weight goes aside and forward to the right one.
    const double right = soft(-0.27 * w.x(), 0.068) - 0.045 * brace - 0.085 * before;  // m
    u[root_x] += scale * -0.50 * right;
    u[root_z] += scale * 0.80 * right;
    u[root_y] +=
        scale * (soft(0.11 * h.y(), 0.032) - 0.022 * brace - 0.045 * before - 0.012 * plays);
    u[pelvis_yaw] += soft(-0.62 * h.x(), 0.20) - 0.18 * before;
    u[spine_yaw] += soft(0.62 * h.x(), 0.20) + soft(0.32 * c.x(), 0.16) + 0.06 * before;
    u[spine_tilt] += soft(-0.16 * c.x(), 0.07);
    u[pelvis_lean] += -0.03 * brace;
    u[spine_lean] += -0.07 * brace + soft(-0.10 * h.y(), 0.04) - 0.05 * before;
    u[left_shoulder_up] += 0.10 * brace;
    u[left_shoulder_forward] += soft(0.5 * left.x(), 0.12);
    // The idle hand goes the other way, and out and up for balance where the stick is fast.
    const Vec3 balance(soft(-0.30 * left.x(), 0.10) + 0.07 * brace + 0.04 * before,
                       soft(-0.16 * left.y(), 0.05) + 0.05 * brace + 0.06 * plays + 0.03 * before,
                       soft(0.26 * left.x(), 0.08) - 0.03 * brace + 0.06 * before + 0.04 * plays);
    u.segment<3>(guard_x) += scale * balance;
  }
}

}  // namespace taut::scenes
