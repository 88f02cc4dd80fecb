// How the trunk and the legs answer the free stick and the strokes of the hand.
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

constexpr double inertia = 0.11;  // s: what is faster the trunk does not follow
constexpr double weight_ahead = 0.12, hips_ahead = 0.05;  // s, of the stick
constexpr double chest_behind = 0.10;                     // s, mean delay
/// Before the hand comes to rest for good the body is again where the path alone has it: what a
/// stick is thrown at must be there.
constexpr double done = 0.45, calms_down = 0.35;  // s

}  // namespace

void answer_stick(const Figure& figure, const Cues& cues, Track& controls) {
  if (!cues.swings) return;
  const double scale = figure.scale();
  const Track slow = cues.off.smoothed(inertia);
  const Track weight = slow.ahead(weight_ahead), hips = slow.ahead(hips_ahead);
  const Track chest = slow.lagged(chest_behind);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i);
    const double share = smoothstep((cues.rests - done - time) / calms_down);
    const double plays = share * cues.plays(time), brace = share * cues.braced.at(time)[0];
    const double follows = share * (1 - 0.3 * brace) / scale;
    const Vec3 w = follows * weight.at(time), h = follows * hips.at(time);
    const Vec3 c = follows * chest.at(time);
    const double before = share * cues.winds_up.at(time)[0];
    auto u = controls.samples().col(i);
    // The feet stand one before the other: the weight goes aside and forward to the right one,
    // whose hip rises; the knees give on the way.
    const double right = soft(-0.50 * w.x(), 0.10) - 0.040 * brace - 0.08 * before;  // m
    u[root_x] += scale * -0.60 * right;
    u[root_z] += scale * 0.80 * right;
    u[root_y] += scale * (soft(0.13 * h.y(), 0.035) - 0.030 * plays - 0.02 * brace - 0.03 * before);
    u[pelvis_tilt] += -1.2 * right;
    u[pelvis_lean] += 0.5 * right;
    u[right_shoulder_forward] += 0.10 * brace;
    // Hips turn against the rib cage, which comes later and leans to the stick's side; from a fast
    // stick he leans away.
    u[pelvis_yaw] += soft(-0.85 * h.x(), 0.28) - 0.28 * before + 0.05 * brace;
    u[spine_yaw] += soft(0.85 * h.x(), 0.28) + soft(0.60 * c.x(), 0.24) + 0.08 * before;
    u[spine_tilt] += soft(-0.80 * c.x(), 0.22) - 0.16 * brace + 0.06 * before;
    u[spine_lean] += soft(-0.12 * h.y(), 0.05) - 0.6 * right + 0.10 * (plays - brace);
  }
}

}  // namespace taut::scenes
