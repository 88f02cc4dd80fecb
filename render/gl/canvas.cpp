#include "render/gl/canvas.h"

#include <fmt/format.h>

#include "render/gl/shaders.h"

namespace taut::gl {
namespace {

// Ten bits hold the square root of light without visible steps at the size of eight.
constexpr GLenum kColorFormat = GL_RGB10_A2;
constexpr GLenum kDepthFormat = GL_DEPTH_COMPONENT24;
constexpr float kEdge = 0.05f;  // of the samples' scale: what differs by less shows no steps
constexpr float kNoEdge = 2;

int checked_samples(const Context& context, int width, int height, int samples) {
  if (width < 1 || height < 1 || std::max(width, height) > context.max_size())
    throw render::NoContext(fmt::format("pictures of {}x{} are beyond the driver ({} at most)",
                                        width, height, context.max_size()));
  if (samples < 1 || samples > context.max_samples())
    throw render::NoContext(fmt::format("{} samples per pixel are beyond the driver ({} at most)",
                                        samples, context.max_samples()));
  return samples;
}

/// The samples (bits) of a share. Patterns of samples are symmetric: opposite ones go together, so
/// that every share lies round the pixel's centre.
GLbitfield share_of_samples(int share, int shares, int samples) {
  GLbitfield mask = 0;
  for (int s = 0; s < samples; ++s)
    if ((shares < samples ? std::min(s, samples - 1 - s) : s) % shares == share) mask |= 1u << s;
  return mask;
}

std::string sample_count(int samples) {
  return fmt::format("#define SAMPLES {}\n", samples);
}

/// What passes over the samples need to know of them: how many, and where in a pixel.
std::string samples_of(const Gl& gl, const GlObject& target, int samples) {
  std::string places;
  gl.BindFramebuffer(GL_FRAMEBUFFER, target.id());
  for (int i = 0; i < samples; ++i) {
    GLfloat at[2] = {0.5f, 0.5f};
    if (samples > 1) gl.GetMultisamplefv(GL_SAMPLE_POSITION, GLuint(i), at);
    places += fmt::format("{}vec2({:.6f}, {:.6f})", i ? ", " : "", at[0] - 0.5f, at[1] - 0.5f);
  }
  return fmt::format("{}const vec2 PLACES[] = vec2[]({});\n{}", sample_count(samples), places,
                     shaders::pixel_light);
}

}  // namespace

Canvas::Samples::Samples(const Gl& gl, int width, int height, int samples)
    : color(make_texture(gl, kColorFormat, width, height, samples)),
      depth(make_texture(gl, kDepthFormat, width, height, samples)),
      target(make_framebuffer(gl, color.id(), depth.id())) {}

Canvas::Light::Light(const Gl& gl, int width, int height)
    : color(make_texture(gl, GL_RGBA16F, width, height)),
      target(make_framebuffer(gl, color.id(), 0)) {}

Canvas::Canvas(const Context& context, int width, int height, int samples)
    : gl_(context.gl()),
      width_(width),
      height_(height),
      samples_(checked_samples(context, width, height, samples)),
      drawn_(gl_, width, height, samples),
      finished_(make_texture(gl_, GL_RGBA8, width, height)),
      finished_target_(make_framebuffer(gl_, finished_.id(), 0)),
      no_vertices_(make_vertex_array(gl_)),
      finish_(gl_, samples_of(gl_, drawn_.target, samples), shaders::cover_vertex,
              shaders::finish_fragment),
      gather_(gl_, samples_of(gl_, drawn_.target, samples), shaders::cover_vertex,
              shaders::gather_fragment),
      finish_gathered_(gl_, sample_count(0), shaders::cover_vertex, shaders::finish_fragment),
      put_(gl_, "", shaders::cover_vertex, shaders::put_fragment) {
  finish_.set("height", height);
  finish_.set("smooth_from", kEdge);
  finish_gathered_.set("height", height);
}

void Canvas::bind() const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn_.target.id());
}

bool Canvas::restore(std::uint64_t backdrop) {
  gathered_ = {};
  // Shadows on it need its own light, not another's.
  on_backdrop_ = kept_ && kept_ == backdrop && kept_lights_ == lights_;
  if (!on_backdrop_) return false;
  if (last_ == backdrop) {
    for (const picture::Rect& part : touched_) copy(backdrop_->samples, drawn_, part);
  } else {
    copy(backdrop_->samples, drawn_, whole());
  }
  last_ = backdrop;
  touched_.clear();
  return true;
}

void Canvas::draw_backdrop(int pictures, const std::function<void(int)>& draw,
                           std::span<const DefocusedView> unfocused) {
  if (!light_) light_.emplace(gl_, width_, height_);
  for (int i = pictures - 1; i >= 0; --i) {
    draw(i);
    // Several pictures have samples enough.
    gather(whole(), *light_, pictures - 1 - i, pictures, pictures > 1 ? kNoEdge : kEdge);
  }
  if (!unfocused.empty()) {
    if (!defocus_) defocus_.emplace(gl_, width_, height_, samples_);
    defocus_->apply(unfocused, light_->color.id(), drawn_.depth.id(), light_->target.id());
  }
  gl_.BindTextureUnit(0, light_->color.id());
  cover(whole(), put_, drawn_.target.id());
  ++lights_;
}

void Canvas::keep(std::uint64_t backdrop) {
  if (last_ == backdrop) {
    if (!backdrop_)
      backdrop_.emplace(Backdrop{Samples(gl_, width_, height_, samples_), picture::Picture()});
    kept_ = 0;
    on_backdrop_ = false;
    backdrop_->picture = finish();
    copy(drawn_, backdrop_->samples, whole());
    kept_ = backdrop;
    kept_lights_ = lights_;
    on_backdrop_ = true;
    touched_.clear();
  }
  last_ = backdrop;
}

void Canvas::touch(const picture::Rect& part) {
  if (part.empty()) return;
  // llvmpipe cuts at a scissor's edge by samples, which lie off the pixels' centres: a pixel more.
  touched_.add(
      picture::intersection({part.x - 1, part.y - 1, part.width + 2, part.height + 2}, whole()));
}

void Canvas::copy(const Samples& from, const picture::Rect& part, const Samples& to, int x,
                  int y) const {
  for (const auto& [source, target] :
       {std::pair(from.color.id(), to.color.id()), {from.depth.id(), to.depth.id()}})
    gl_.CopyImageSubData(source, GL_TEXTURE_2D_MULTISAMPLE, 0, part.x, part.y, 0, target,
                         GL_TEXTURE_2D_MULTISAMPLE, 0, x, y, 0, part.width, part.height, 1);
}

/// For pictures of several times of a part of that size, which begin in so many ways.
void Canvas::make_room(const picture::Rect& part, std::size_t starts) {
  if (!exposure_ || exposure_->width < part.width || exposure_->height < part.height) {
    constexpr int kMore = 64;  // px, so that it is not made anew for every pixel
    const auto enough = [](int had, int needed, int most) {
      return std::max(had, std::min((needed + kMore - 1) / kMore * kMore, most));
    };
    const int width = enough(exposure_ ? exposure_->width : 0, part.width, width_);
    const int height = enough(exposure_ ? exposure_->height : 0, part.height, height_);
    exposure_.reset();
    exposure_.emplace(Exposure{width, height, std::vector<Samples>(), Light(gl_, width, height)});
  }
  while (exposure_->starts.size() < starts)
    exposure_->starts.emplace_back(gl_, exposure_->width, exposure_->height, samples_);
}

/// The exposures of one picture, each with its share of the samples.
void Canvas::expose_shares(const Exposed& exposed, int picture) const {
  const int pictures = std::max(exposed.count / samples_, 1);
  const int shares = std::min(exposed.count, samples_);
  gl_.Enable(GL_SAMPLE_MASK);
  for (int share = 0; share < shares; ++share) {
    gl_.SampleMaski(0, share_of_samples(share, shares, samples_));
    exposed.draw(share * pictures + picture);
  }
  gl_.Disable(GL_SAMPLE_MASK);
}

void Canvas::expose(std::span<const Exposed> parts) {
  for (const Exposed& exposed : parts) touch(exposed.part);
  while (!parts.empty() && parts.front().count < 2 * samples_) {
    expose_shares(parts.front(), 0);
    parts = parts.subspan(1);
  }
  if (parts.empty()) return;

  picture::Rect all;
  for (const Exposed& exposed : parts) all = picture::hull(all, exposed.part);
  make_room(all, parts.size());
  gathered_ = all;
  const picture::Rect here{0, 0, all.width, all.height};
  const int pictures = parts.back().count / samples_;
  for (int picture = 0; picture < pictures; ++picture) {
    // What takes fewer exposures stays as it is for some pictures.
    const auto lasts = [&](const Exposed& exposed) { return parts.back().count / exposed.count; };
    std::size_t changed = 0;
    while (picture % lasts(parts[changed]) != 0) ++changed;
    if (picture > 0) copy(exposure_->starts[changed], here, drawn_, all.x, all.y);
    for (std::size_t k = changed; k < parts.size(); ++k) {
      if (picture == 0 || k > changed) copy(drawn_, all, exposure_->starts[k], 0, 0);
      expose_shares(parts[k], picture / lasts(parts[k]));
    }
    gather(all, exposure_->light, picture, pictures, kEdge);
  }
}

int Canvas::exposure_among(int fewer, int i, int count) const {
  if (fewer == count) return i;
  if (fewer >= samples_) return i * fewer / count;
  const int pictures = std::max(count / samples_, 1);
  const GLbitfield mine = share_of_samples(i / pictures, std::min(count, samples_), samples_);
  int share = 0;
  while ((share_of_samples(share, fewer, samples_) & mine) != mine) ++share;
  return share;
}

/// Adds the share of one of several pictures to their mean light.
void Canvas::gather(const picture::Rect& part, const Light& light, int picture, int pictures,
                    float smooth_from) {
  gather_.set("smooth_from", smooth_from);
  gather_.set("share", 1.0f / float(pictures));
  gl_.Disable(GL_BLEND);
  if (picture > 0) {
    gl_.Enable(GL_BLEND);
    gl_.BlendFunc(GL_ONE, GL_ONE);
  }
  gl_.BindTextureUnit(0, drawn_.color.id());
  gather_.set("corner", part.x, part.y);
  cover({0, 0, part.width, part.height}, gather_, light.target.id());
  gl_.Disable(GL_BLEND);
}

void Canvas::resolve() {
  const auto flipped =
      [this](const picture::Rect& part) {  // finished pictures begin with their top row
        return picture::Rect{part.x, height_ - part.top(), part.width, part.height};
      };
  gl_.Disable(GL_BLEND);
  gl_.BindTextureUnit(0, drawn_.color.id());
  if (on_backdrop_) {
    for (const picture::Rect& part : touched_) cover(flipped(part), finish_, finished_target_.id());
  } else {
    cover(whole(), finish_, finished_target_.id());
  }
  if (gathered_.empty()) return;
  gl_.BindTextureUnit(0, exposure_->light.color.id());
  finish_gathered_.set("corner", gathered_.x, gathered_.y);
  cover(flipped(gathered_), finish_gathered_, finished_target_.id());
}

/// Runs a program for every pixel of a part.
void Canvas::cover(const picture::Rect& part, const Program& program, GLuint target) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target);
  gl_.Viewport(0, 0, width_, height_);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(part.x, part.y, part.width, part.height);
  gl_.BindVertexArray(no_vertices_.id());
  program.use();
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_SCISSOR_TEST);
}

picture::Picture Canvas::read() const {
  if (!on_backdrop_) {
    picture::Picture picture(width_, height_);
    read(whole(), picture);
    return picture;
  }
  picture::Picture picture = backdrop_->picture;
  for (const picture::Rect& part : touched_) read(part, picture);
  return picture;
}

void Canvas::read(const picture::Rect& part, picture::Picture& picture) const {
  const int top = height_ - part.top();  // finished pictures begin with their top row
  gl_.BindFramebuffer(GL_FRAMEBUFFER, finished_target_.id());
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, width_);
  gl_.ReadPixels(part.x, top, part.width, part.height, GL_RGBA, GL_UNSIGNED_BYTE,
                 picture.at(part.x, top));
}

}  // namespace taut::gl
