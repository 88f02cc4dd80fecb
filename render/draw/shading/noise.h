// The texture that wood and skin take their irregularity from.
#pragma once

#include "render/gl/gpu.h"

namespace taut::draw {

/// Two channels of tiling fractal noise around 1/2, with mipmaps, repeating beyond its edge.
gl::GlObject make_noise_texture(const gl::Gl& gl);

}  // namespace taut::draw
