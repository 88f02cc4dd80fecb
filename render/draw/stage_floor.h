// Lower bounds of the time of a frame's stages.
#pragma once

#include <optional>
#include <string_view>

#include "render/gl/profile.h"

namespace taut::draw {

/// Floors of stages, from what this machine can do.
class StageFloor {
 public:
  /// Measures how fast one core copies memory: some hundredths of a second.
  StageFloor(int width, int height, int samples);

  /// CPU time (s) below which a stage cannot come: of one that draws lit surfaces, what the same
  /// triangles and samples take in one colour (`unlit`, the profile of such frames); of one that
  /// moves pixels, its bytes at the speed of copying. None where neither is known.
  std::optional<double> of(std::string_view stage, const gl::Profile& unlit) const;

 private:
  double pixels_, samples_;
  double speed_;  // B/s, read and written together
};

}  // namespace taut::draw
