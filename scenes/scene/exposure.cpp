#include "scenes/scene/exposure.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace taut::scenes {
namespace {

/// Into how many equal steps the scene's method divides a frame; for methods that choose their
/// steps, into how many parts times are rounded.
std::uint64_t steps_per_frame(const Scene& scene) {
  constexpr std::uint64_t kFine = 1024;
  const double step = step_of(with_defaults(scene.method));
  return step > 0 ? step_count(1.0 / scene.fps, step) : kFine;
}

}  // namespace

double own_time(const Scene& scene, double time) {
  // A single quotient, so that a time has the same bits however it was come by.
  const double rate = double(steps_per_frame(scene)) * scene.fps;
  return std::round(time * rate) / rate;
}

std::vector<double> exposure_times(const Scene& scene, double time, double rate) {
  const double open = scene.stage ? scene.stage->shutter * rate / scene.fps : 0;
  if (open == 0) return {time};
  // A little more, as the quotient of a whole number of steps may fall short of it.
  const auto steps = unsigned(open * scene.fps * double(steps_per_frame(scene)) * (1 + 1e-9));
  const int states = std::min(int(std::bit_floor(std::max(steps, 1u))), scene.stage->exposures);
  std::vector<double> times;
  for (int i = 0; i < states; ++i) {
    times.push_back(std::max(own_time(scene, time + (i - states / 2) * open / states), 0.0));
  }
  return times;
}

}  // namespace taut::scenes
