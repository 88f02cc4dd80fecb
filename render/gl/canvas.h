// Where pictures are drawn: multisampled colour and depth, and the passes that finish them.
#pragma once

#include <functional>
#include <optional>

#include "render/gl/context.h"
#include "render/gl/defocus.h"
#include "render/gl/gpu.h"
#include "render/picture/picture.h"
#include "render/picture/rect.h"

namespace taut::gl {

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
  /// Blurs what has been drawn in this frame, the backdrop, by how far it is out of focus.
  void defocus(std::span<const DefocusedView> views);
  /// The blurred light for surfaces that shade it (Defocus::blurred); 0: none was ever blurred.
  GLuint defocused() const { return defocus_ ? defocus_->blurred() : 0; }
  /// Declares the drawing of this frame so far a backdrop, kept when it comes a second time
  /// running: behind a moving camera, keeping would be wasted.
  void keep(std::uint64_t backdrop);
  /// Marks a part as drawn over the backdrop.
  void touch(const picture::Rect& part);

  /// Draws `count` exposures over a part of the picture: `draw(i)` for each i below `count`, a
  /// divisor or a multiple of samples(). Each takes its share of the samples of every pixel, at
  /// least one; more exposures than samples make several pictures, each of times from the whole
  /// shutter, whose mean is taken. No drawing may follow several pictures.
  void expose(const picture::Rect& part, int count, const std::function<void(int)>& draw);
  /// The exposure of `fewer` whose samples contain those of exposure `i` of `count`. `fewer` is a
  /// divisor of samples(), or `count`.
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
  void make_room(const picture::Rect& part);
  void gather(const picture::Rect& part, int picture, int pictures);
  void cover(const picture::Rect& part, const Program& program, GLuint target) const;
  void read(const picture::Rect& part, picture::Picture& picture) const;
  picture::Rect whole() const { return {0, 0, width_, height_}; }

  const Gl& gl_;
  int width_, height_, samples_;
  Samples drawn_;
  GlObject finished_, finished_target_;
  GlObject no_vertices_;
  Program finish_, gather_, finish_gathered_;
  /// The start of every picture of several exposures, and the mean light of those done: of a part
  /// of the picture, as fast things are mostly small.
  struct Exposure {
    int width, height;
    Samples start;
    GlObject light, target;
  };
  std::optional<Exposure> exposure_;
  picture::Rect gathered_;  // the part of the frame in Exposure::light

  std::optional<Backdrop> backdrop_;
  std::optional<Defocus> defocus_;
  std::uint64_t blurs_ = 0, kept_blurs_ = 0;  // how often defocus_ was used, and at what is kept
  std::uint64_t last_ = 0, kept_ = 0;         // names of backdrops; 0: none
  bool on_backdrop_ = false;                  // in this frame
  picture::RectSet touched_;
};

}  // namespace taut::gl
