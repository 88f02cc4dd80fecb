// Cards: a heading and a few lines over a picture that steps back.
#pragma once

#include <string_view>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut {

/// `method` stands where the text says {method}; `shown` from 0, nothing of the card, to 1.
void draw_card(Picture& picture, Font& font, Font& bold, const Card& card, std::string_view method,
               double shown);

}  // namespace taut
