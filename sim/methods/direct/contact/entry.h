// Where on its way something enters an obstacle, and how near it is then.
#pragma once

#include <algorithm>

namespace taut::direct {

constexpr double kReached = 1e-8;  // m: that near, it is there
constexpr double kEntered = 1e-2;  // times touching: what else of a thing that touches is inside
constexpr double kShortOf = 100;   // times touching: a hit that was located is this near
constexpr double kNudge = 100;     // times touching: to see how a touch changes with places

struct Entry {
  double share = 2;     // of the way; above 1: nowhere
  bool passes = false;  // it is outside again at the end
  bool stays = false;   // it was inside all the way, as far as that can be seen
};

/// The share of a way on which `inside(share)` begins to hold, which it does not at `outside`.
double first_inside(double outside, double within, const auto& inside) {
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings && within - outside > 1e-15; ++i) {
    const double middle = (outside + within) / 2;
    (inside(middle) ? within : outside) = middle;
  }
  return within;
}

/// The obstacle is `distance(share)` away (m; below zero: it is inside) at a share of the way,
/// which is `way` (m) long at most in the obstacle's frame. A way that ends outside is followed by
/// strides of the distance, none of which can enter.
Entry find_entry(double at_start, double at_end, double way, const auto& distance) {
  constexpr double kStride = 1e-4;  // of the way, at least, from one evaluation to the next
  const auto inside = [&](double share) { return !(distance(share) > 0); };
  double outside = 0;
  if (at_end >= 0) {
    if (at_start + at_end > way) return {};
    double share = at_start > kReached ? 0 : kStride;
    for (double apart = distance(share); apart > kReached; apart = distance(share)) {
      outside = share;
      share += std::max(apart / way, kStride);
      if (share >= 1) return {};
    }
    if (outside == 0 && !(at_start > kReached)) return {};  // it has only just left
    return {.share = first_inside(outside, share, inside), .passes = true};
  }
  if (!(at_start > 0)) {
    outside = 0.5;
    while (outside > kStride && inside(outside)) outside /= 2;
    if (!(outside > kStride)) return {.share = 1, .stays = true};
  }
  return {.share = first_inside(outside, 1, inside)};
}

}  // namespace taut::direct
