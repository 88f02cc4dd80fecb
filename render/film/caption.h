// Captions: a quiet line of text at the lower left, within the title-safe nine tenths of the
// picture. A soft shadow of the letters sets it off from whatever is behind.
#pragma once

#include <limits>
#include <span>
#include <string_view>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {

/// A time of the scene (s), and the part of it that is on without a cut.
struct Playing {
  double time = 0;
  double from = 0, until = std::numeric_limits<double>::infinity();  // s
  double rate = 1;  // seconds of the scene to one of the clip
};

/// Draws the captions that are on: softly come, softly gone, but not at a cut. Captions too short
/// to be read, of less than 0.45 s of the clip, are left out.
void draw_captions(picture::Picture& picture, picture::Font& font,
                   std::span<const scenes::Caption> captions, const Playing& playing);

/// Draws a small line at the upper left, as long as it is asked for.
void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text);

}  // namespace taut::film
