#include "render/draw/shading/noise.h"

#include <cmath>
#include <cstdint>

namespace taut::draw {
namespace {

/// An even hash of a lattice point, 0 to 1.
float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return float((h ^ (h >> 15)) >> 8) / float(1u << 24);
}

float smooth(float t) {
  return t * t * (3 - 2 * t);
}

/// Value noise that repeats after `period` cells.
float value_noise(float x, float y, std::uint32_t period, std::uint32_t seed) {
  const auto x0 = std::uint32_t(x), y0 = std::uint32_t(y);
  const float u = smooth(x - float(x0)), v = smooth(y - float(y0));
  const auto at = [&](std::uint32_t i, std::uint32_t j) {
    return lattice((x0 + i) % period, (y0 + j) % period, seed);
  };
  return std::lerp(std::lerp(at(0, 0), at(1, 0), u), std::lerp(at(0, 1), at(1, 1), u), v);
}

}  // namespace

gl::GlObject make_noise_texture(const gl::Gl& gl) {
  constexpr int kSize = 256, kLevels = 9;
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      for (std::uint32_t channel = 0; channel < 2; ++channel) {
        // The second channel starts at finer cells.
        float sum = 0, amplitude = 0.5f;
        for (std::uint32_t octave = 0, period = channel ? 32 : 8; octave < 4; ++octave) {
          const float scale = float(period) / kSize;
          sum += amplitude *
                 value_noise(float(x) * scale, float(y) * scale, period, 8 * channel + octave);
          amplitude *= 0.5f;
          period = std::min(2 * period, std::uint32_t(kSize));
        }
        pixels.push_back(std::uint8_t(std::lround(255 * sum / (1 - amplitude * 2))));
      }
  gl::GlObject texture = gl::make_texture(gl, GL_RG8, kSize, kSize, 0, kLevels);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, kSize, kSize, GL_RG, GL_UNSIGNED_BYTE, pixels.data());
  gl.GenerateTextureMipmap(texture.id());
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

}  // namespace taut::draw
