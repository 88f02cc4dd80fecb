#include "render/draw/shading/scenery_shadow.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "render/draw/shading/lighting.h"
#include "render/gl/shaders.h"

namespace taut::draw {
namespace {

constexpr int kSize = 2048;  // texels; 6 mm of a room of 12 m
constexpr int kBlock = 16;   // texels of a span: penumbras are narrower
constexpr int kBlocks = kSize / kBlock;

using Span = Eigen::Vector2f;  // least and greatest depth

/// The span of each block, and then of it and its neighbours.
std::vector<Span> spans_of(const std::vector<float>& depths) {
  std::vector<Span> own(std::size_t(kBlocks * kBlocks), Span(1, 0)), wide = own;
  const auto add = [](Span& span, float least, float greatest) {
    span = {std::min(span.x(), least), std::max(span.y(), greatest)};
  };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const float depth = depths[std::size_t(y) * kSize + std::size_t(x)];
      add(own[std::size_t(y / kBlock * kBlocks + x / kBlock)], depth, depth);
    }
  for (int y = 0; y < kBlocks; ++y)
    for (int x = 0; x < kBlocks; ++x)
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kBlocks - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kBlocks - 1); ++i) {
          const Span& near = own[std::size_t(j * kBlocks + i)];
          add(wide[std::size_t(y * kBlocks + x)], near.x(), near.y());
        }
  return wide;
}

/// A matrix as a constant of GLSL.
std::string glsl(const Eigen::Matrix4f& m) {
  return fmt::format("mat4({:.9g})", fmt::join(m.data(), m.data() + 16, ", "));
}

}  // namespace

SceneryShadow::SceneryShadow(const gl::Gl& gl, const scenes::Light& light,
                             std::span<Drawable> things)
    : gl_(gl), projection_(Eigen::Matrix4f::Zero()) {
  const Eigen::AlignedBox3d room = box_around(things);
  if (!light.scenery_casts || room.isEmpty()) return;
  projection_ = light_map(light.direction, room, kSize).projection;
  depths_ = gl::make_texture(gl, GL_DEPTH_COMPONENT32F, kSize, kSize);
  plainly_ = gl::make_depth_sampler(gl);
  const gl::GlObject target = gl::make_framebuffer(gl, 0, depths_.id());
  const gl::Program program(gl,
                            fmt::format("const mat4 light_projection = {};\n", glsl(projection_)),
                            gl::shaders::depth_vertex, gl::shaders::depth_fragment);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.id());
  gl.Viewport(0, 0, kSize, kSize);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_LESS);
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(GL_FRONT);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_SCISSOR_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  program.use();
  program.set("model", Eigen::Matrix4f(Eigen::Matrix4f::Identity()));
  for (const Drawable& thing : things) thing.draw();
  std::vector<float> depths(std::size_t(kSize) * kSize);
  gl.PixelStorei(GL_PACK_ROW_LENGTH, kSize);
  gl.ReadPixels(0, 0, kSize, kSize, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  const std::vector<Span> spans = spans_of(depths);
  spans_ = gl::make_texture(gl, GL_RG32F, kBlocks, kBlocks);
  gl.TextureParameteri(spans_.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TextureParameteri(spans_.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureSubImage2D(spans_.id(), 0, 0, 0, kBlocks, kBlocks, GL_RG, GL_FLOAT, spans.data());
}

std::string SceneryShadow::constants() const {
  std::string text = fmt::format("#define CASTING {:d}\n", bool(depths_));
  if (depths_)
    text += fmt::format("const mat4 SCENERY_MAP = {};\n#define SCENERY_PENUMBRA {:.9g}\n",
                        glsl(projection_), penumbra(projection_));
  return text + gl::shaders::past_scenery;
}

void SceneryShadow::bind() const {
  if (!depths_) return;
  gl_.BindTextureUnit(5, depths_.id());
  gl_.BindSampler(5, plainly_.id());
  gl_.BindTextureUnit(6, spans_.id());
}

}  // namespace taut::draw
