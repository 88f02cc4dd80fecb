// Scenes to export: everything that moves, pins and cuts, a body that can be a link.
#pragma once

namespace taut {

/// A cord between a driven and a free body, and a rope that is pinned and then cut.
constexpr const char* kPinnedAndCut = R"(duration = 0.5
fps = 50
[method]
name = "xpbd"
step = 0.0005
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
[connectors.rope]
length = 1
mass = 0.1
particles = 11
from = { fixed = [1, 1, 0] }
to = { free = true }
start = { direction = [1, -1, 0] }
[[pins]]
connector = "rope"
at = 0.55
from = 0.1
until = 0.3
[[cuts]]
connector = "rope"
at = 0.75
t = 0.2
)";

/// A stick on a cord, which can be simulated as the first link of that.
constexpr const char* kBodyAsLink = R"(duration = 0.2
fps = 50
[method]
name = "direct"
tolerance = 1e-6
[bodies.stick]
mass = 0.12
shape = { cylinder = { length = 0.30, diameter = 0.028 } }
hangs = [1, -1, 0]
[connectors.cord]
length = 0.4
mass = 0.01
particles = 5
from = { body = "stick", point = [0, 0.15, 0] }
to = { fixed = [1, 1, 0] }
start = { direction = [1, 0, 0] }
)";

}  // namespace taut
