#include "scenes/scene/scene_method.h"

#include <fmt/format.h>

#include <cmath>

namespace taut::scenes {

MethodChoice default_method() {
  return {"direct", {}};
}

std::optional<double> dividing_step(double step, int fps) {
  // A step is the longest allowed. The next shorter one that divides the frame stands for it where
  // the two are within 2%, as 1/1020 s does for 0.001 s at 60 frames per second.
  const double fitted = 1 / (fps * std::ceil(1 / (fps * step) - 1e-6));
  if (std::abs(fitted - step) > 0.02 * step) return {};
  return fitted;
}

std::string dividing_text(double step, int fps) {
  const double count = std::ceil(1 / (fps * step));
  return fmt::format("a step that divides the frame of 1/{} s, such as {:.12g} (1/{} s)", fps,
                     1 / (fps * count), fps * count);
}

}  // namespace taut::scenes
