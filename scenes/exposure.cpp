#include "scenes/exposure.h"

#include <algorithm>
#include <cmath>

namespace taut {
namespace {

/// The step (s) that the scene's method takes in every frame; 0: it chooses from step to step.
double own_step(const Scene& scene) {
  const MethodInfo& method = *find_method(scene.method.name);
  const Settings settings = with_defaults(method, scene.method.settings);
  const auto step = settings.find("step");
  if (step == settings.end() || !(std::get<double>(step->second) > 0)) return 0;
  const double frame = 1.0 / scene.fps;
  return frame / static_cast<double>(step_count(frame, std::get<double>(step->second)));
}

}  // namespace

double own_time(const Scene& scene, double time) {
  const double step = own_step(scene);
  if (step == 0) return time;
  const double own = std::round(time / step) * step;
  return std::abs(own - time) < 1e-6 * step ? time : own;
}

std::vector<double> exposure_times(const Scene& scene, double time, double rate) {
  const double open = scene.stage ? scene.stage->shutter * rate / scene.fps : 0;
  if (open == 0) return {time};
  std::vector<double> times;
  for (int i = 0; i < kExposureStates; ++i) {
    const int off = i - kExposureStates / 2;
    times.push_back(off == 0 ? time
                             : std::max(own_time(scene, time + off * open / kExposureStates), 0.0));
  }
  return times;
}

}  // namespace taut
