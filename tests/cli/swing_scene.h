// A small scene with a stage: a stick on a short cord swings from a fixed point.
#pragma once

#include <string>

namespace taut {

/// At 50 frames per second, for `duration` s.
inline std::string swing_scene(double duration) {
  return "duration = " + std::to_string(duration) + R"(
fps = 50
size = [64, 36]
[method]
name = "impulse"
step = 0.001
[bodies.free]
mass = 0.12
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
hangs = [0, -1, 0]
[connectors.cord]
length = 0.1
mass = 0.01
particles = 3
from = { fixed = [0, 1, 0] }
to = { body = "free", point = [0, 0.15, 0] }
start = { direction = [1, -1, 0] }
[stage]
camera = [{ t = 0, position = [0, 0.9, 1], target = [0, 0.8, 0] }]
)";
}

}  // namespace taut
