#include "scenes/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/motion/stop.h"

namespace taut::scenes {

int frame_count(double duration, int fps) {
  const double count = duration * fps, nearest = std::round(count);
  return static_cast<int>(std::abs(count - nearest) < 1e-9 * count ? nearest : std::ceil(count));
}

int Scene::frames() const {
  return frame_count(duration, fps);
}

Simulation start(const Scene& scene) {
  return start(scene, scene.method);
}

Simulation start(const Scene& scene, const MethodChoice& method) {
  return {scene.world, make_method(method.name, method.settings), scene.timeline};
}

void settle_breaks(Scene& scene) {
  settle_breaks(scene, scene.method);
}

void settle_breaks(Scene& scene, const MethodChoice& method) {
  const auto may_break = [](const Connector& one) { return std::isfinite(one.breaks_at); };
  if (std::ranges::none_of(scene.world.connectors, may_break)) return;
  Simulation simulation = start(scene, method);
  try {
    for (int frame = 0; frame < scene.frames(); ++frame) {
      check_stop();
      simulation.advance_to(static_cast<double>(frame) / scene.fps);
    }
  } catch (const Diverged&) {  // the scene's own run does as well
  }
  scene.breaks = simulation.breaks();
  for (const Simulation::Break& found : scene.breaks) {
    TimedCut& cut = scene.timeline.cuts.emplace_back(found.cut);
    cut.source = "breaks_at of " + found.connector;
  }
  for (Connector& connector : scene.world.connectors) {
    connector.breaks_at = std::numeric_limits<double>::infinity();
  }
}

}  // namespace taut::scenes
