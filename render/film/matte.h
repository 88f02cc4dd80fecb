// Pictures made of several: opacity from two, more samples from shifted ones, a contact sheet.
#pragma once

#include <Eigen/Core>
#include <span>

#include "render/picture/picture.h"

namespace taut::film {

/// The picture that, laid over black, is `on_black` and, over white, `on_white`: its fourth bytes
/// are opacity, and its colours are not multiplied by that.
picture::Picture matte(const picture::Picture& on_black, const picture::Picture& on_white);

/// The pictures whose mean has `samples` per pixel where a driver has at most `limit`.
struct Passes {
  Passes(int samples, int limit)
      : count((samples + limit - 1) / limit), each((samples + count - 1) / count) {}
  int count, each;  // pictures, and the samples of each
  /// What picture `i` is moved by, px: so that its samples lie between those of the others.
  Eigen::Vector2f shift(int i) const {
    const float x = (float(i) - float(count - 1) / 2) / float(count * each);
    return {x, -x};
  }
};

/// The mean of the light of pictures of one size.
picture::Picture mean(std::span<const picture::Picture> pictures);

// Several pictures as one.

/// Pictures of one size side by side, `columns` to a row.
picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns);

}  // namespace taut::film
