// Several pictures as one.
#pragma once

#include <span>

#include "render/picture/picture.h"

namespace taut {

/// Pictures of one size side by side, `columns` to a row.
Picture contact_sheet(std::span<const Picture> pictures, int columns);

}  // namespace taut
