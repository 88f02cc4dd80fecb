// Depth of field of what stands: a drawn picture blurred by how far everything is out of focus.
#pragma once

#include <span>

#include "render/gl/gpu.h"
#include "render/picture/picture.h"

namespace taut::gl {

/// A lens's circles of confusion, in pixels of the picture: the radius at the depth buffer's 0 and
/// 1, linear between, negative in front of the focus.
struct Confusion {
  float nearest = 0, farthest = 0;
};

/// A part of a picture, and how it is out of focus.
struct DefocusedView {
  picture::Rect part;
  Confusion confusion;
};

/// Gathers, for each pixel, the light of all whose circles reach it (after Jimenez 2014). A thing
/// in focus stays as it was drawn, and its light spreads over nothing; nothing farther spreads over
/// it. A thing that is blurred in front of the focus is so within its outline.
class Defocus {
 public:
  Defocus(const Gl& gl, int width, int height, int samples);

  /// Blurs the light of each pixel. `depth` is multisampled; `target` draws into `light`.
  void apply(std::span<const DefocusedView> views, GLuint light, GLuint depth, GLuint target);

 private:
  void cover(const picture::Rect& part, const Program& program, GLuint target) const;

  const Gl& gl_;
  int width_, height_;
  GlObject sharp_, sharp_target_;  // light, its mipmaps; alpha: the circle's signed radius
  GlObject wide_, wide_target_;    // wide circles, in pixels of half the size
  GlObject no_vertices_;
  Program collect_, gather_wide_, gather_;
};

}  // namespace taut::gl
