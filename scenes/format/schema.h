// The format of scene files, for editors.
#pragma once

#include <string>

namespace taut::scenes {

/// A JSON Schema (draft 7, which editors know best) of what load_scene accepts, made from the same
/// description by which scenes are checked.
std::string scene_schema();

}  // namespace taut::scenes
