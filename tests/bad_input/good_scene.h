// A scene with a bit of everything, which each fault spoils in one place.
#pragma once

#include <string_view>

namespace taut {

inline constexpr std::string_view kGoodScene = R"(schema_version = 1
title = "Good"
duration = 1.0
fps = 60
size = [480, 270]
gravity = [0.0, -9.81, 0.0]

[method]
name = "impulse"
step = 0.001

[paths.hand]
keys = [
  { t = 0.0, position = [0.0, 1.0, 0.0], rotation = [1, 0, 0, 0] },
  { t = 0.5, position = [0.2, 1.0, 0.0], axis = [0, 1, 0], hold = 0.1 },
]

[bodies.held]
mass = 0.12
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
driven_by = { path = "hand" }

[bodies.free]
mass = 0.12
inertia = [0.001, 0.0001, 0.001]
hangs = [0.0, -1.0, 0.0]

[connectors.chain]
length = 0.12
mass = 0.012
particles = 11
from = { body = "held", point = [0.0, 0.15, 0.0] }
to = { body = "free", point = [0.0, 0.15, 0.0] }
start = { direction = [0.0, -1.0, 0.0] }

[[pins]]
connector = "chain"
at = 0.06
from = 0.2
until = 0.4
)";

}  // namespace taut
