// Opacity, found from two pictures of the same thing.
#pragma once

#include "render/picture/picture.h"

namespace taut {

/// The picture that, laid over black, is `on_black` and, over white, `on_white`: its fourth bytes
/// are opacity, and its colours are not multiplied by that.
Picture matte(const Picture& on_black, const Picture& on_white);

}  // namespace taut
