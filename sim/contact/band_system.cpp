#include "sim/contact/band_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace taut::contact {
namespace {

constexpr double kBandSingular = 1e-13;  // of a column's largest entry: a pivot below is rounding

}  // namespace

void BandSystem::clear(std::size_t size, std::size_t half) {
  size_ = size;
  half_ = half;
  height_ = 3 * half + 1;
  band_.assign(size * height_, 0);
  scale_.resize(size);
  pivot_.resize(size);
}

void BandSystem::factor() {
  for (std::size_t j = 0; j < size_; ++j) {
    const std::span column(&band_[j * height_], height_);
    double most = 0;
    for (const double entry : column) most = std::max(most, std::abs(entry));
    scale_[j] = most > 0 ? 1 / most : 0;
    for (double& entry : column) entry *= scale_[j];
  }
  for (std::size_t j = 0; j < size_; ++j) {
    const std::size_t below = std::min(half_, size_ - 1 - j);
    const std::size_t right = std::min(2 * half_, size_ - 1 - j);
    double* own = &band_[j * height_ + 2 * half_];  // its diagonal
    std::size_t best = 0;
    for (std::size_t i = 1; i <= below; ++i) {
      if (std::abs(own[i]) > std::abs(own[best])) best = i;
    }
    pivot_[j] = best;
    if (!(std::abs(own[best]) > kBandSingular)) {
      scale_[j] = 0;
      std::fill_n(own, below + 1, 0.0);
      continue;
    }
    const double inverse = 1 / own[best];
    std::swap(own[0], own[best]);
    for (std::size_t i = 1; i <= below; ++i) own[i] *= inverse;
    own[0] = inverse;
    for (std::size_t k = 1; k <= right; ++k) {
      double* other = own + k * (height_ - 1);  // the same row, k columns on
      std::swap(other[0], other[best]);
      const double factor = other[0];
      if (factor == 0) continue;
      for (std::size_t i = 1; i <= below; ++i) other[i] -= own[i] * factor;
    }
  }
}

void BandSystem::solve(std::span<double> x) const {
  for (std::size_t j = 0; j < size_; ++j) {
    if (scale_[j] == 0) continue;
    const std::size_t below = std::min(half_, size_ - 1 - j);
    const double* own = &band_[j * height_ + 2 * half_];
    std::swap(x[j], x[j + pivot_[j]]);
    for (std::size_t i = 1; i <= below; ++i) x[j + i] -= own[i] * x[j];
  }
  for (std::size_t j = size_; j-- > 0;) {
    const double* own = &band_[j * height_ + 2 * half_];
    x[j] = scale_[j] == 0 ? 0 : x[j] * own[0];
    const std::size_t above = std::min(2 * half_, j);
    for (std::size_t i = 1; i <= above; ++i)
      x[j - i] -= own[-static_cast<std::ptrdiff_t>(i)] * x[j];
  }
  for (std::size_t j = 0; j < size_; ++j) x[j] *= scale_[j];
}

}  // namespace taut::contact
