// How he waits before he plays, and how he greets when he has.
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

// While he waits he stands higher, on the foot behind; m and rad, as differences from his stance,
// for a figure of 1.78 m.
const Vec3 pelvis_waits(0.030, 0.030, -0.045);
constexpr double bows = 0.15, nods = 0.32;  // rad, of the back, and of the head beyond that

}  // namespace

void begin_and_end(const Figure& figure, const Cues& cues, Track& controls) {
  const double scale = figure.scale();
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double time = controls.time(i), waits = 1 - cues.ready(time);
    auto u = controls.samples().col(i);
    u.segment<3>(root_x) += scale * waits * pelvis_waits;
    u[pelvis_yaw] -= 0.10 * waits;
    u[spine_lean] += 0.03 * waits;
    const double rises = cues.rises(time), nod = cues.nod(time);
    u[spine_yaw] += 0.055 * rises;
    u[spine_lean] += bows * nod;
    u[head_lean] += nods * nod;
  }
}

}  // namespace taut::scenes
