// How he waits before he plays, and how he greets when he has.
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

// While he waits he stands higher, on the foot behind, and the left fist is at the belt; m and rad,
// as differences from his stance, for a figure of 1.78 m.
const Vec3 pelvis_waits(0.030, 0.030, -0.045);
const Vec3 fist_waits(0.065, -0.085, 0.045);
// In the end the left fist comes before the chest.
const Vec3 fist_greets(-0.075, 0.035, -0.01);
constexpr double fist_after = 0.10, fist_takes = 0.45;  // s, after all rests
constexpr double nods = 0.24;                           // rad, of the head beyond where it looks

}  // namespace

void begin_and_end(const Figure& figure, const Cues& cues, Track& controls) {
  const double scale = figure.scale();
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i), waits = 1 - cues.ready(time);
    auto u = controls.samples().col(i);
    u.segment<3>(root_x) += scale * waits * pelvis_waits;
    u.segment<3>(guard_x) += scale * waits * fist_waits;
    u[pelvis_yaw] -= 0.10 * waits;
    u[spine_lean] += 0.03 * waits;
    if (!cues.greets()) continue;
    const double since = time - cues.rests;
    u.segment<3>(guard_x) += scale * smoothstep((since - fist_after) / fist_takes) * fist_greets;
    u[head_lean] += nods * cues.nod(time);
  }
}

}  // namespace taut::scenes
