// The choreography of a scene.
#pragma once

#include "scenes/format/document.h"
#include "scenes/reader/motions.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// What a scene's choreography asks for, of its world and timeline. Throws BadScene.
Choreographed read_choreography(const Document& document, const Value& table,
                                const Motions& motions, const Scene& scene);

}  // namespace taut::scenes
