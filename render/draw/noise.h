// The texture that wood and skin take their irregularity from.
#pragma once

#include "render/gl/gpu.h"

namespace taut {

/// Two channels of tiling fractal noise around 1/2, with mipmaps, repeating beyond its edge.
GlObject make_noise_texture(const Gl& gl);

}  // namespace taut
