// Several pictures as one.
#pragma once

#include <span>

#include "render/picture/picture.h"

namespace taut::film {

/// Pictures of one size side by side, `columns` to a row.
picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns);

}  // namespace taut::film
