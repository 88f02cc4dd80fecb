// Pictures made of several: opacity from two, a contact sheet from many.
#pragma once

#include <span>

#include "render/picture/picture.h"

namespace taut::film {

/// The picture that, laid over black, is `on_black` and, over white, `on_white`: its fourth bytes
/// are opacity, and its colours are not multiplied by that.
picture::Picture matte(const picture::Picture& on_black, const picture::Picture& on_white);

// Several pictures as one.

/// Pictures of one size side by side, `columns` to a row.
picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns);

}  // namespace taut::film
