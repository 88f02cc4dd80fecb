// What the face shows.
#include <algorithm>
#include <cmath>

#include "scenes/character/acting.h"

namespace taut::scenes {
namespace {

constexpr double busy = 0.2, strained = 8;   // m/s, m/s^2: of the hand, half of an expression
constexpr double wakes = 0.10, calms = 0.3;  // s, mean delays of concentration and of ease
constexpr double over = 0.2;                 // s of rest, after which all is over
constexpr double seen_coming = 0.08;         // s, by which the face is ahead of the hand

/// From 0 to 1, a half at `half`.
double share(double x, double half) {
  return x * x / (x * x + half * half);
}

}  // namespace

void play_face(const Figure& figure, const Path& path, Track& controls) {
  const Track hand = Track::sample(
      controls.time(controls.count() - 1), acting_rate,
      [&](double time) { return Eigen::VectorXd(path.at(time).position / figure.scale()); });
  Track speed = hand.rates(), force = speed.smoothed(0.02).rates();
  speed.samples() = speed.samples().colwise().norm().eval();
  force.samples() = force.samples().colwise().norm().eval();
  const auto each = [](const Track& track, double half) {
    Track out = track;
    out.samples() = track.samples().unaryExpr([half](double x) { return share(x, half); });
    return out;
  };
  const Track moving = each(speed.smoothed(0.15), busy);
  const Track effort = each(force.smoothed(0.04), strained).ahead(seen_coming).lagged(wakes / 2);
  const Track concentration = moving.smoothed(calms).ahead(seen_coming).lagged(wakes);

  // Rest counts once the hand has moved, and only where it lasts.
  Track ease = moving;
  const auto lasts = static_cast<Eigen::Index>(over * moving.rate());
  bool moved = false;
  Eigen::Index since = 0;  // the last sample at which the hand moved
  for (Eigen::Index i = 0; i < moving.count(); ++i) {
    const double now = moving[i][0];
    moved = moved || now > 0.5;
    if (now > 0.3) since = i;
    ease.samples()(0, i) = moved && i - since > lasts ? 1 : 0;
  }
  const Track pleased = ease.lagged(calms);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double strain = effort[i][0], content = pleased[i][0];
    const double attention = concentration[i][0] * (1 - content);
    auto c = controls.samples().col(i);
    c[brows] = 0.5 * content - 0.5 * attention - 0.5 * strain;
    c[frown] = std::min(1.0, 0.5 * attention + 0.8 * strain);
    c[smile] = content - 0.25 * attention;
    c[jaw] = std::max(0.8 * strain - 0.2, 0.0) + 0.1 * content;
    // Narrowed eyes blink all the same.
    c[lids] = std::max(c[lids], 0.12 * attention + 0.22 * strain + 0.10 * content);
  }
}

}  // namespace taut::scenes
