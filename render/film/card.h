// Cards: a heading and a few lines over a picture that steps back.
#pragma once

#include <string_view>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {

/// `method` stands where the text says {method}; `shown` from 0, nothing of the card, to 1.
void draw_card(picture::Picture& picture, picture::Font& font, picture::Font& bold,
               const scenes::Card& card, std::string_view method, double shown);

}  // namespace taut::film
