// Dotted keys of a scene, as in connectors.rope.length.
#pragma once

#include <string_view>

namespace taut::scenes {

/// True where a key is one of the scene format, by its first word.
bool is_scene_key(std::string_view key);

}  // namespace taut::scenes
