// Where pictures are drawn: multisampled colour and depth, and the passes that finish them.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "render/gl/context.h"
#include "render/gl/defocus.h"
#include "render/gl/gpu.h"
#include "render/picture/picture.h"

namespace taut::gl {

/// A part of a picture, to be drawn `count` times: `draw(i)` for each i below that, a divisor or a
/// multiple of the canvas's samples.
struct Exposed {
  picture::Rect part;
  int count;
  std::function<void(int)> draw;
};

/// Colours are stored as the square root of tone-mapped light and averaged as light.
///
/// A canvas can keep a backdrop, what has been drawn before anything moved. Frames on the same
/// backdrop then pay for what they touch alone: elsewhere the picture is the backdrop's own.
class Canvas {
 public:
  /// Throws NoContext where the driver allows no such size or number of samples.
  Canvas(const Context& context, int width, int height, int samples);

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }

  /// Makes the canvas the target of drawing.
  void bind() const;

  /// Begins a frame with the backdrop of that name; false where there is none.
  bool restore(std::uint64_t backdrop);
  /// Draws a backdrop over the whole canvas: `draw(i)` for each i from `pictures` - 1 down to 0,
  /// the same thing moved within a pixel. Each sample then has its pixel's mean light, blurred by
  /// how far views are out of focus; the depths are the last picture's.
  void draw_backdrop(int pictures, const std::function<void(int)>& draw,
                     std::span<const DefocusedView> unfocused);
  /// The light of the last backdrop's pixels, for surfaces that shade it; 0: there was none.
  GLuint backdrop_light() const { return light_ ? light_->color.id() : 0; }
  /// Declares the drawing of this frame so far a backdrop, kept when it comes a second time
  /// running: behind a moving camera, keeping would be wasted.
  void keep(std::uint64_t backdrop);
  /// Marks a part as drawn over the backdrop.
  void touch(const picture::Rect& part);

  /// Draws exposures over parts of the picture, each part over those before it, with counts that
  /// divide the next. Each exposure takes its share of the samples of every pixel, at least one;
  /// more exposures than samples make several pictures, each of times from the whole shutter, whose
  /// mean is taken. No drawing may follow several pictures.
  void expose(std::span<const Exposed> parts);
  /// The exposure of `fewer` whose samples contain those of exposure `i` of `count`. `fewer`
  /// divides `count`; one of the two divides samples(), or both are multiples of it.
  int exposure_among(int fewer, int i, int count) const;

  /// Finishes what was drawn: samples averaged, sRGB, dithered.
  void resolve();
  /// The finished picture.
  picture::Picture read() const;
  picture::Picture finish() {
    resolve();
    return read();
  }

 private:
  /// The multisampled samples of colour and depth.
  struct Samples {
    Samples(const Gl& gl, int width, int height, int samples);
    GlObject color, depth, target;
  };
  struct Backdrop {
    Samples samples;
    picture::Picture picture;
  };
  /// Of `part`, to where its corner is at (x, y).
  void copy(const Samples& from, const picture::Rect& part, const Samples& to, int x, int y) const;
  void copy(const Samples& from, const Samples& to, const picture::Rect& part) const {
    copy(from, part, to, part.x, part.y);
  }
  void make_room(const picture::Rect& part, std::size_t starts);
  void expose_shares(const Exposed& exposed, int picture) const;
  /// The light of pixels, and what draws into it.
  struct Light {
    Light(const Gl& gl, int width, int height);
    GlObject color, target;
  };
  void gather(const picture::Rect& part, const Light& light, int picture, int pictures,
              float smooth_from);
  void cover(const picture::Rect& part, const Program& program, GLuint target) const;
  void read(const picture::Rect& part, picture::Picture& picture) const;
  picture::Rect whole() const { return {0, 0, width_, height_}; }

  const Gl& gl_;
  int width_, height_, samples_;
  Samples drawn_;
  GlObject finished_, finished_target_;
  GlObject no_vertices_;
  Program finish_, gather_, finish_gathered_, put_;
  /// What the pictures of each of several counts of exposures begin with, and the mean light of
  /// those done: of a part of the picture, as fast things are mostly small.
  struct Exposure {
    int width, height;
    std::vector<Samples> starts;
    Light light;
  };
  std::optional<Exposure> exposure_;
  picture::Rect gathered_;  // the part of the frame in Exposure::light

  std::optional<Backdrop> backdrop_;
  std::optional<Light> light_;
  std::optional<Defocus> defocus_;
  std::uint64_t lights_ = 0, kept_lights_ = 0;  // how often light_ was drawn, and for what is kept
  std::uint64_t last_ = 0, kept_ = 0;           // names of backdrops; 0: none
  bool on_backdrop_ = false;                    // in this frame
  picture::RectSet touched_;
};

}  // namespace taut::gl
