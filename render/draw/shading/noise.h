// The texture that wood, cloth and skin take their irregularity from.
#pragma once

#include "render/gl/gpu.h"

namespace taut::draw {

/// Two channels of tiling fractal noise around 1/2, and the slopes of creases along both axes,
/// which lie where the first is 1/2: by 510 ths, over four texels, from 128 of 255. With mipmaps,
/// repeating beyond its edge.
gl::GlObject make_noise_texture(const gl::Gl& gl);

}  // namespace taut::draw
