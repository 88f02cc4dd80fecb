#include "render/canvas.h"

#include <fmt/format.h>

#include "render/shaders.h"

namespace taut {
namespace {

// Ten bits hold the square root of light without visible steps at the size of eight.
constexpr GLenum kColorFormat = GL_RGB10_A2;

int checked_samples(const Context& context, int width, int height, int samples) {
  if (width < 1 || height < 1 || std::max(width, height) > context.max_size())
    throw NoContext(fmt::format("pictures of {}x{} are beyond the driver ({} at most)", width,
                                height, context.max_size()));
  if (samples < 1 || samples > context.max_samples())
    throw NoContext(fmt::format("{} samples per pixel are beyond the driver ({} at most)", samples,
                                context.max_samples()));
  return samples;
}

}  // namespace

Canvas::Canvas(const Context& context, int width, int height, int samples)
    : gl_(context.gl()),
      width_(width),
      height_(height),
      samples_(checked_samples(context, width, height, samples)),
      color_(make_texture(gl_, kColorFormat, width, height, samples)),
      depth_(make_texture(gl_, GL_DEPTH_COMPONENT24, width, height, samples)),
      target_(make_framebuffer(gl_, color_.id(), depth_.id())),
      finished_(make_texture(gl_, GL_RGBA8, width, height)),
      finished_target_(make_framebuffer(gl_, finished_.id(), 0)),
      no_vertices_(make_vertex_array(gl_)),
      finish_(gl_, fmt::format("#define SAMPLES {}\n", samples), shaders::cover_vertex,
              shaders::finish_fragment) {
  finish_.set("height", height);
}

void Canvas::bind() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.id());
}

void Canvas::resolve() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, finished_target_.id());
  gl_.Viewport(0, 0, width_, height_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
  gl_.BindTextureUnit(0, color_.id());
  gl_.BindVertexArray(no_vertices_.id());
  finish_.use();
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

Picture Canvas::read() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, finished_target_.id());
  Picture picture(width_, height_);
  gl_.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, picture.pixels.data());
  return picture;
}

}  // namespace taut
