// Where pictures are drawn: multisampled colour and depth, and the passes that finish them.
#pragma once

#include "render/context.h"
#include "render/gpu.h"
#include "render/picture.h"

namespace taut {

/// A rectangle of pixels from the lower left corner.
struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Colours are stored as the square root of tone-mapped light and averaged as light.
class Canvas {
 public:
  /// Throws NoContext where the driver allows no such size or number of samples.
  Canvas(const Context& context, int width, int height, int samples);

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }

  /// Makes the canvas the target of drawing.
  void bind() const;
  /// Finishes what was drawn: samples averaged, sRGB, dithered.
  void resolve();
  /// The finished picture.
  Picture read() const;
  Picture finish() {
    resolve();
    return read();
  }

 private:
  const Gl& gl_;
  int width_, height_, samples_;
  GlObject color_, depth_, target_;
  GlObject finished_, finished_target_;
  GlObject no_vertices_;
  Program finish_;
};

}  // namespace taut
