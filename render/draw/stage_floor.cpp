#include "render/draw/stage_floor.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include "sim/run/cpu_time.h"

namespace taut::draw {
namespace {

/// B/s of CPU time, read and written together.
double copying_speed() {
  constexpr std::size_t kBytes = std::size_t{1} << 25;  // beyond any cache
  std::vector<char> from(kBytes, 1), to(kBytes);
  double best = std::numeric_limits<double>::infinity();
  for (char round = 0; round < 5; ++round) {
    from[0] = round;
    const double start = thread_seconds();
    std::memcpy(to.data(), from.data(), kBytes);
    if (to[0] == round) best = std::min(best, thread_seconds() - start);
  }
  return 2 * double(kBytes) / best;
}

}  // namespace

StageFloor::StageFloor(int width, int height, int samples)
    : pixels_(double(width) * height), samples_(samples), speed_(copying_speed()) {}

std::optional<double> StageFloor::of(std::string_view stage, const gl::Profile& unlit) const {
  constexpr double kColor = 4, kRgb = 3;  // B
  if (stage == "resolve and tone map") return pixels_ * (samples_ + 1) * kColor / speed_;
  if (stage == "read back" || stage == "captions") return pixels_ * 2 * kColor / speed_;
  if (stage == "PNG") return pixels_ * (kColor + kRgb) / speed_;
  if (stage != "scenery" && stage != "figures" && stage != "shadows" && stage != "exposures")
    return std::nullopt;
  const auto found = std::ranges::find(unlit.stages(), stage, &gl::Profile::Stage::name);
  if (found == unlit.stages().end()) return std::nullopt;
  return gl::median(*found).cpu;
}

}  // namespace taut::draw
