// Captions and cards: quiet text at the lower left, within the title-safe nine tenths; headings
// on a ground of their own.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
/// to be read, of less than 0.45 s of the clip, are left out. A newline breaks the line. Captions
/// at the same time are stacked, from the bottom up in the order in which they come, and each keeps
/// its height while it is on.
void draw_captions(picture::Picture& picture, picture::Font& font,
                   std::span<const scenes::Caption> captions, const Playing& playing);

/// Which characters of captions and cards their fonts lack: a sentence for each caption and card.
/// Throws std::runtime_error where a font is missing.
std::vector<std::string> missing_glyphs(const scenes::Stage& stage);

/// Draws a small line at the upper left, as long as it is asked for.
void draw_note(picture::Picture& picture, picture::Font& font, std::string_view text);

// Cards: a heading and a few lines on a ground of their own.

/// `method` stands where the text says {method}. `shown` goes from 0, the picture alone, to 1: at
/// first the ground comes over the picture, from a half on the lines upon it.
void draw_card(picture::Picture& picture, picture::Font& font, picture::Font& bold,
               const scenes::Card& card, std::string_view method, double shown);

}  // namespace taut::film
