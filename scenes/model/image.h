// Pictures that models bring.
#pragma once

#include <string_view>

#include "scenes/model/model.h"

namespace taut::scenes {

enum class ImageKind { png, jpeg, other };
ImageKind kind_of_image(std::string_view bytes);

/// The picture of a PNG or JPEG file, of `most` pixels or fewer. Throws std::runtime_error with the
/// cause where it is broken, larger, or of colours that are not read (CMYK).
Texture decode_image(std::string_view bytes, std::size_t most);

}  // namespace taut::scenes
