#include "scenes/scene/scene.h"

#include <cmath>

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

}  // namespace taut::scenes
