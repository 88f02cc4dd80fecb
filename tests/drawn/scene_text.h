// Scene files that nobody chose, drawn from a seed: connectors of all models, what holds them,
// bodies, paths, obstacles, strings, pins and cuts.
#pragma once

#include <string>

namespace taut::drawn {

/// A scene of a second. Most can be; the reader refuses the others, such as those with a body
/// inside of an obstacle.
std::string scene_text(unsigned seed);

}  // namespace taut::drawn
