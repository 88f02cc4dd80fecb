#include "render/draw/shading/noise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace taut::draw {
namespace {

/// An even hash of a lattice point, 0 to 1.
float hashed(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return float((h ^ (h >> 15)) >> 8) / float(1u << 24);
}

float smooth(float t) {
  return t * t * (3 - 2 * t);
}

/// Value noise that repeats after `period` cells.
class ValueNoise {
 public:
  ValueNoise(std::uint32_t period, std::uint32_t seed) : period_(period) {
    for (std::uint32_t y = 0; y < period; ++y)
      for (std::uint32_t x = 0; x < period; ++x) lattice_.push_back(hashed(x, y, seed));
  }

  /// For places in the first period, in cells.
  float at(float x, float y) const {
    const auto x0 = std::uint32_t(x), y0 = std::uint32_t(y);
    const float u = smooth(x - float(x0)), v = smooth(y - float(y0));
    const std::uint32_t x1 = x0 + 1 < period_ ? x0 + 1 : 0, y1 = y0 + 1 < period_ ? y0 + 1 : 0;
    const float *row = &lattice_[y0 * period_], *next = &lattice_[y1 * period_];
    return between(between(row[x0], row[x1], u), between(next[x0], next[x1], u), v);
  }

 private:
  static float between(float a, float b, float t) { return a + t * (b - a); }

  std::uint32_t period_;
  std::vector<float> lattice_;
};

}  // namespace

gl::GlObject make_noise_texture(const gl::Gl& gl) {
  constexpr int kSize = 256, kLevels = 9, kOctaves = 4, kChannels = 4;
  std::vector<std::uint8_t> pixels(kChannels * kSize * kSize);
  const auto channels = [&](int x, int y) {
    return &pixels[kChannels * std::size_t(y % kSize * kSize + x % kSize)];
  };
  for (std::uint32_t channel = 0; channel < 2; ++channel) {
    std::vector<ValueNoise> octaves;
    std::vector<float> scales;                // cells of a pixel
    std::uint32_t period = channel ? 32 : 8;  // the second channel starts at finer cells
    for (std::uint32_t octave = 0; octave < kOctaves; ++octave) {
      octaves.emplace_back(period, 8 * channel + octave);
      scales.push_back(float(period) / kSize);
      period = std::min(2 * period, std::uint32_t(kSize));
    }
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        float sum = 0, amplitude = 0.5f;
        for (std::size_t i = 0; i < kOctaves; ++i) {
          sum += amplitude * octaves[i].at(float(x) * scales[i], float(y) * scales[i]);
          amplitude *= 0.5f;
        }
        channels(x, y)[channel] = std::uint8_t(std::lround(255 * sum / (1 - amplitude * 2)));
      }
  }
  // Creases are where the first channel is 1/2. Their slope is the difference over four texels: its
  // 8 bits show in one.
  constexpr int kOver = 4, kNoRise = 128;
  const auto height = [&](int x, int y) { return -std::abs(2 * int(channels(x, y)[0]) - 255); };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int here = height(x, y);
      const auto rise = [&](int there) {
        return std::uint8_t(std::clamp(kNoRise + there - here, 0, 255));
      };
      channels(x, y)[2] = rise(height(x + kOver, y));
      channels(x, y)[3] = rise(height(x, y + kOver));
    }
  gl::GlObject texture = gl::make_texture(gl, GL_RGBA8, kSize, kSize, 0, kLevels);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, kSize, kSize, GL_RGBA, GL_UNSIGNED_BYTE,
                       pixels.data());
  gl.GenerateTextureMipmap(texture.id());
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

}  // namespace taut::draw
