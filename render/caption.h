// Captions: quiet lines of text at the lower left that come and go softly. Neighbours of one list
// stand above each other, the one whose time it is bright among the others.
#pragma once

#include <span>

#include "render/text.h"
#include "scenes/stage.h"

namespace taut {

/// Draws the captions that show at `time` (s).
void draw_captions(Picture& picture, Font& font, std::span<const Caption> captions, double time);

}  // namespace taut
