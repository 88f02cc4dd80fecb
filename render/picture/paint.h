// Flat shapes and lines of text on finished pictures.
#pragma once

#include <array>
#include <span>
#include <string>

#include "render/picture/picture.h"
#include "render/picture/rect.h"
#include "render/picture/text.h"

namespace taut::picture {

/// Blends a colour over a rectangle (from the upper left corner), as far as it lies inside.
void fill(Picture& picture, const Rect& rect, Rgb color, double opacity = 1);

/// Blends a line through points (px from the upper left corner) over the picture, its edges and its
/// joints smooth; a point that is not finite breaks it.
void stroke(Picture& picture, std::span<const std::array<double, 2>> points, double width,
            Rgb color, double opacity = 1);

/// A point of a ribbon: px from the upper left corner, px across, and how much of it covers.
struct RibbonPoint {
  double x, y, width, opacity;
};
/// Blends a line through points over the picture as stroke() does, its width and its opacity even
/// between them; a point that is not finite breaks it.
void ribbon(Picture& picture, std::span<const RibbonPoint> points, Rgb color);

/// Blends a colour over the picture softly round a line of text, at most `opacity` of it and
/// nothing farther than the letters' size away: pale letters over it are read on any ground.
void draw_shadow(Picture& picture, Font& font, std::string_view text, double x, double y,
                 double size, Rgb color, double opacity);

/// Copies a picture into another, its upper left corner at (x, y); it must fit.
void paste(const Picture& from, Picture& to, int x, int y);

/// Each `factor` x `factor` pixels averaged into one.
Picture shrunk(const Picture& picture, int factor);

/// Text broken into lines no wider than `width` pixels where its words allow.
std::vector<std::string> wrapped(Font& font, const std::string& text, double size, double width);

}  // namespace taut::picture
