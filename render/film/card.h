// Cards: a heading and a few lines on a ground of their own.
#pragma once

#include <string_view>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {

/// `method` stands where the text says {method}. `shown` goes from 0, the picture alone, to 1: at
/// first the ground comes over the picture, from a half on the lines upon it.
void draw_card(picture::Picture& picture, picture::Font& font, picture::Font& bold,
               const scenes::Card& card, std::string_view method, double shown);

}  // namespace taut::film
