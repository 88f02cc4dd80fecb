// Captions: quiet lines of text at the lower left that come and go softly. A list shows the line
// whose time it is and, fainter, the one before it above and the next below; it rolls from line to
// line.
#pragma once

#include <span>
#include <string_view>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {

/// Draws the captions that show at `time` (s).
void draw_captions(picture::Picture& picture, picture::Font& font,
                   std::span<const scenes::Caption> captions, double time);

/// Draws a small line at the upper left, as long as it is asked for.
void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text);

}  // namespace taut::film
