// Small scenes that tests of the program share.
#pragma once

#include <string>

namespace taut {

/// A rope of four particles swings from the horizontal for 0.2 s at 20 frames per second: what a
/// study takes the least time for.
inline constexpr const char* kShortSwing = R"(title = "Short swing"
duration = 0.2
fps = 20
size = [96, 54]
[connectors.rope]
length = 0.2
mass = 0.05
particles = 4
from = { fixed = [0, 0.6, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
)";

/// Two sticks on a cord, a hanging one and a driven one: five frames of 20 steps.
inline constexpr const char* kPushedStick = R"(duration = 0.1
fps = 50
[method]
name = "impulse"
step = 0.001
[paths.hand]
keys = [{ t = 0, position = [0, 1, 0] }, { t = 1, position = [0.5, 1, 0] }]
[bodies.free]
mass = 0.12
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
hangs = [0, -1, 0]
[bodies.held]
mass = 0.12
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
driven_by = { path = "hand" }
[connectors.cord]
length = 0.1
mass = 0.01
particles = 3
from = { body = "held", point = [0, -0.15, 0] }
to = { body = "free", point = [0, 0.15, 0] }
start = { direction = [0, -1, 0] }
)";

/// A stick on a short cord swings from a fixed point. At 50 frames per second, for `duration` s.
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
