#include "render/draw/shading/shadow_map.h"

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
}

void ShadowMap::clear() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
}

void ShadowMap::draw(std::span<const DrawItem> casters) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
  gl_.Viewport(0, 0, size_, size_);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(2, 2, size_ - 4, size_ - 4);
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
