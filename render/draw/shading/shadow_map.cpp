#include "render/draw/shading/shadow_map.h"

#include <algorithm>

#include "render/gl/shaders.h"

namespace taut::draw {
namespace {

constexpr GLenum kFormat = GL_DEPTH_COMPONENT16;  // a sixth of a millimetre on 11 m

}  // namespace

ShadowMap::ShadowMap(const gl::Gl& gl, int size)
    : gl_(gl),
      size_(size),
      map_(gl::make_texture(gl, kFormat, size, size)),
      target_(gl::make_framebuffer(gl, 0, map_.id())),
      depths_(gl::make_depth_sampler(gl)),
      depth_program_(gl, gl::shaders::frame_block, gl::shaders::depth_vertex,
                     gl::shaders::depth_fragment) {
  gl.TextureParameteri(map_.id(), GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(map_.id(), GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

void ShadowMap::bind() const {
  gl_.BindTextureUnit(0, map_.id());
  gl_.BindTextureUnit(4, map_.id());
  gl_.BindSampler(4, depths_.id());
  if (layers_) gl_.BindTextureUnit(8, layers_.id());
}

void ShadowMap::clear() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::draw(std::span<const DrawItem> casters) const {
  draw(target_, 0, 0, casters);
}

void ShadowMap::draw_layer(int layer, std::span<const DrawItem> casters) const {
  draw(layer_targets_[std::size_t(layer)], layered_.x, layered_.y, casters);
}

/// Into a target whose corner is at (x, y) of the map.
void ShadowMap::draw(const gl::GlObject& target, int x, int y,
                     std::span<const DrawItem> casters) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target.id());
  gl_.Viewport(-x, -y, size_, size_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(2 - x, 2 - y, size_ - 4, size_ - 4);
  gl_.Enable(GL_DEPTH_CLAMP);
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  gl_.PolygonOffset(1.5f, 2.0f);
  depth_program_.use();
  for (const DrawItem& item : casters) {
    if (item.triangles.empty()) continue;
    depth_program_.set("model", item.model);
    item.draw();
  }
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Disable(GL_DEPTH_CLAMP);
  gl_.Disable(GL_SCISSOR_TEST);
}

void ShadowMap::start_layers(const picture::Rect& part, int count) {
  constexpr int kMore = 128;  // texels, so that they are not made anew for every texel
  const auto enough = [&](int had, int needed) {
    return std::max(had, std::min((needed + kMore - 1) / kMore * kMore, size_));
  };
  const int had = int(layer_targets_.size());
  if (part.width > layered_.width || part.height > layered_.height || count > had) {
    layered_.width = enough(layered_.width, part.width);
    layered_.height = enough(layered_.height, part.height);
    layer_targets_.clear();
    layers_ = {};
    layers_ =
        gl::make_depth_layers(gl_, kFormat, layered_.width, layered_.height, std::max(had, count));
    for (int layer = 0; layer < std::max(had, count); ++layer)
      layer_targets_.push_back(gl::make_layer_framebuffer(gl_, layers_.id(), layer));
  }
  // They end where the map does, or within it.
  layered_.x = std::clamp(part.x, 0, size_ - layered_.width);
  layered_.y = std::clamp(part.y, 0, size_ - layered_.height);
}

void ShadowMap::keep_layer(int layer) const {
  gl_.CopyImageSubData(map_.id(), GL_TEXTURE_2D, 0, layered_.x, layered_.y, 0, layers_.id(),
                       GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, layered_.width, layered_.height, 1);
}

Eigen::Vector4f ShadowMap::on_layers() const {
  const auto size = float(size_), width = float(layered_.width), height = float(layered_.height);
  return {size / width, size / height, -float(layered_.x) / width, -float(layered_.y) / height};
}

void ShadowMap::save(const picture::Rect& part) {
  if (!saved_) saved_ = gl::make_texture(gl_, kFormat, size_, size_);
  copy(map_.id(), saved_.id(), part);
}

void ShadowMap::restore(const picture::Rect& part) const {
  copy(saved_.id(), map_.id(), part);
}

void ShadowMap::copy(GLuint from, GLuint to, const picture::Rect& part) const {
  if (part.empty()) return;
  gl_.CopyImageSubData(from, GL_TEXTURE_2D, 0, part.x, part.y, 0, to, GL_TEXTURE_2D, 0, part.x,
                       part.y, 0, part.width, part.height, 1);
}

}  // namespace taut::draw
