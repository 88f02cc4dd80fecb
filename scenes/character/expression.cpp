// What the face shows.
#include <algorithm>
#include <cmath>

#include "scenes/character/acting.h"

namespace taut::scenes {
namespace {

// The hand's speed (m/s) and acceleration (m/s^2) that make half of an expression.
constexpr double half_speed = 0.2, half_acceleration = 8;
constexpr double attack = 0.10, release = 0.3;  // s, mean delays of a face that tightens, and eases
constexpr double anticipation = 0.08;           // s, by which the face is ahead of the hand
constexpr double calm_lids = 0.12;              // how far down they are without any effort
constexpr double lids_rise = 0.85;              // by this much per rad that the eyes look up
constexpr double least_rest = 0.2;              // s, after which the hand has come to rest

/// From 0 to 1, a half at `half`.
double share(double x, double half) {
  return x * x / (x * x + half * half);
}

}  // namespace

void play_face(const Figure& figure, const Path& path, Track& controls, const Cues& cues) {
  const Track hand = Track::sample(
      controls.time(controls.count() - 1), acting_rate,
      [&](double time) { return Eigen::VectorXd(path.at(time).position / figure.scale()); });
  Track speed = hand.rates(), acceleration = speed.smoothed(0.02).rates();
  speed.samples() = speed.samples().colwise().norm().eval();
  acceleration.samples() = acceleration.samples().colwise().norm().eval();
  const auto each = [](const Track& track, double half) {
    Track out = track;
    out.samples() = track.samples().unaryExpr([half](double x) { return share(x, half); });
    return out;
  };
  const Track moving = each(speed.smoothed(0.15), half_speed);
  const Track effort =
      each(acceleration.smoothed(0.04), half_acceleration).ahead(anticipation).lagged(attack / 2);
  const Track concentration = moving.smoothed(release).ahead(anticipation).lagged(attack);

  // Rest counts once the hand has moved, and only where it lasts.
  Track ease = moving;
  const auto lasts = static_cast<Eigen::Index>(least_rest * moving.rate());
  bool moved = false;
  Eigen::Index since = 0;  // the last sample at which the hand moved
  for (Eigen::Index i = 0; i < moving.count(); ++i) {
    const double now = moving[i][0];
    moved = moved || now > 0.5;
    if (now > 0.3) since = i;
    ease.samples()(0, i) = moved && i - since > lasts ? 1 : 0;
  }
  const Track calmed = ease.lagged(release);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const double strain = effort[i][0], calm = calmed[i][0];
    const double attention = concentration[i][0] * (1 - calm);
    auto c = controls.samples().col(i);
    c[brows] = -0.55 * calm - 0.2 * attention - 0.9 * strain;
    c[frown] = std::min(1.0, 0.35 * calm + 0.2 * attention + 0.9 * strain);
    c[smile] = calm - 0.25 * attention;
    c[jaw] = std::max(0.8 * strain - 0.2, 0.0) + 0.1 * calm;
    // Narrowed eyes blink all the same, and open for what is above them and what flies past.
    const double narrowed = (calm_lids + 0.02 * attention + 0.14 * strain + 0.02 * calm) *
                            (1 - cues.passes(controls.time(i)));
    c[lids] = std::max(c[lids], narrowed + lids_rise * std::min(c[eye_lean], 0.0));
  }
}

}  // namespace taut::scenes
