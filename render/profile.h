// Where a frame's time goes.
#pragma once

#include <string>
#include <vector>

#include "render/gl.h"

namespace taut {

/// Sums of the CPU and wall time of a frame's stages. Measuring waits for the rasteriser after each
/// stage, which costs a little of what it measures.
class Profile {
 public:
  struct Stage {
    std::string name;
    double cpu = 0, wall = 0;  // s, all frames together
  };

  /// Begins a frame.
  void start();
  /// Ends a stage: the time since the last lap is its.
  void lap(const Gl& gl, const char* stage);

  const std::vector<Stage>& stages() const { return stages_; }

 private:
  std::vector<Stage> stages_;
  double cpu_ = 0, wall_ = 0;
};

}  // namespace taut
