// Ribbons that show which way points came.
#pragma once

#include <span>

#include "render/draw/view.h"
#include "render/picture/picture.h"

namespace taut::film {

/// Draws the instant's trails over its picture, narrower and fainter where they are older.
void draw_trails(picture::Picture& picture, std::span<const scenes::Trail> trails,
                 const draw::FrameState& instant);

}  // namespace taut::film
