#include "render/canvas.h"

#include <fmt/format.h>

#include "render/shaders.h"

namespace taut {
namespace {

// Ten bits hold the square root of light without visible steps at the size of eight.
constexpr GLenum kColorFormat = GL_RGB10_A2;
constexpr GLenum kDepthFormat = GL_DEPTH_COMPONENT24;

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

Canvas::Samples::Samples(const Gl& gl, int width, int height, int samples)
    : color(make_texture(gl, kColorFormat, width, height, samples)),
      depth(make_texture(gl, kDepthFormat, width, height, samples)),
      target(make_framebuffer(gl, color.id(), depth.id())) {}

Canvas::Canvas(const Context& context, int width, int height, int samples)
    : gl_(context.gl()),
      width_(width),
      height_(height),
      samples_(checked_samples(context, width, height, samples)),
      drawn_(gl_, width, height, samples),
      finished_(make_texture(gl_, GL_RGBA8, width, height)),
      finished_target_(make_framebuffer(gl_, finished_.id(), 0)),
      no_vertices_(make_vertex_array(gl_)),
      finish_(gl_, fmt::format("#define SAMPLES {}\n", samples), shaders::cover_vertex,
              shaders::finish_fragment) {
  finish_.set("height", height);
}

void Canvas::bind() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn_.target.id());
}

bool Canvas::restore(std::uint64_t backdrop) {
  on_backdrop_ = kept_ && kept_ == backdrop;
  if (!on_backdrop_) return false;
  for (const Rect& part : touched_) copy(backdrop_->samples, drawn_, part);
  touched_.clear();
  return true;
}

void Canvas::keep(std::uint64_t backdrop) {
  if (last_ == backdrop) {
    if (!backdrop_) backdrop_.emplace(Samples(gl_, width_, height_, samples_), Picture());
    kept_ = 0;
    on_backdrop_ = false;
    backdrop_->picture = finish();
    copy(drawn_, backdrop_->samples, whole());
    kept_ = backdrop;
    on_backdrop_ = true;
    touched_.clear();
  }
  last_ = backdrop;
}

void Canvas::touch(const Rect& part) {
  if (part.empty()) return;
  // llvmpipe cuts at a scissor's edge by samples, which lie off the pixels' centres: a pixel more.
  touched_.add(intersection({part.x - 1, part.y - 1, part.width + 2, part.height + 2}, whole()));
}

void Canvas::copy(const Samples& from, const Samples& to, const Rect& part) const {
  for (const auto& [source, target] :
       {std::pair(from.color.id(), to.color.id()), {from.depth.id(), to.depth.id()}})
    gl_.CopyImageSubData(source, GL_TEXTURE_2D_MULTISAMPLE, 0, part.x, part.y, 0, target,
                         GL_TEXTURE_2D_MULTISAMPLE, 0, part.x, part.y, 0, part.width, part.height,
                         1);
}

void Canvas::resolve() {
  if (!on_backdrop_) return resolve(whole());
  for (const Rect& part : touched_) resolve(part);
}

void Canvas::resolve(const Rect& part) {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, finished_target_.id());
  gl_.Viewport(0, 0, width_, height_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(part.x, height_ - part.top(), part.width, part.height);
  gl_.BindTextureUnit(0, drawn_.color.id());
  gl_.BindVertexArray(no_vertices_.id());
  finish_.use();
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_SCISSOR_TEST);
}

Picture Canvas::read() const {
  if (!on_backdrop_) {
    Picture picture(width_, height_);
    read(whole(), picture);
    return picture;
  }
  Picture picture = backdrop_->picture;
  for (const Rect& part : touched_) read(part, picture);
  return picture;
}

void Canvas::read(const Rect& part, Picture& picture) const {
  const int top = height_ - part.top();  // finished pictures begin with their top row
  gl_.BindFramebuffer(GL_FRAMEBUFFER, finished_target_.id());
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, width_);
  gl_.ReadPixels(part.x, top, part.width, part.height, GL_RGBA, GL_UNSIGNED_BYTE,
                 picture.at(part.x, top));
}

}  // namespace taut
