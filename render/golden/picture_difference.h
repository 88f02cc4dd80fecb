// How two pictures differ: the measures by which golden pictures are compared.
#pragma once

#include "render/picture/picture.h"

namespace taut::golden {

struct PictureDifference {
  double above_2 = 0;     // share of pixels with a channel more than 2 (of 255) apart
  int largest = 0;        // the largest distance of any channel
  double mean_shift = 0;  // the largest channel's |mean difference|
  // Share of pixels that lie, in one of the pictures, more than 8 away from every pixel within one
  // of them in the other.
  double near_above_8 = 0;
};

/// Throws std::invalid_argument where the sizes differ.
PictureDifference difference(const picture::Picture& actual, const picture::Picture& golden);

/// As two runs of one driver should be: at most 0.01% of the pixels differ by more than 2, none by
/// more than 16, and the means by at most 0.3.
bool same_rendering(const PictureDifference& difference);

/// As two drivers may be: edges may move by a pixel, 0.1% of the pixels may differ by more than 8.
bool same_picture(const PictureDifference& difference);

}  // namespace taut::golden
