// The left arm: its guard while the right hand plays, from pose to pose.
#include <array>
#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

/// Where the left wrist is about the chest's joint: how far round to the left of its front (rad),
/// how far off and how high (m, for a figure of 1.78 m); and the sides to which elbow and thumb
/// are.
struct Guard {
  double round, off, height;
  Vec3 elbow, thumb;
};
const Guard at_ease{0.36, 0.28, -0.12, {0.8, -1.0, -0.5}, {-0.2, 1.0, 0.0}};
const Guard at_the_belt{0.08, 0.31, -0.17, {1.0, -0.6, -0.5}, {-0.1, 1.0, 0.0}};
const Guard open{0.02, 0.34, 0.03, {1.0, -0.9, -0.2}, {0.2, 1.0, 0.0}};
const Guard balancing{1.30, 0.60, 0.20, {0.3, -1.0, -0.2}, {0.0, 0.45, 1.0}};
const Guard across{-0.30, 0.30, 0.02, {1.0, -0.6, 0.2}, {-0.9, 0.5, 0.0}};
const Guard chambered{1.40, 0.26, -0.14, {0.35, -0.4, -1.0}, {1.0, 0.25, 0.2}};
const Guard greeting{-0.55, 0.30, 0.04, {0.5, -1.0, 0.1}, {0.75, 0.7, 0.1}};

constexpr Eigen::Index rows = 9;
using Row = Eigen::Matrix<double, rows, 1>;
Row row(const Guard& guard) {
  Row r;
  r << guard.round, guard.off, guard.height, guard.elbow.normalized(), guard.thumb.normalized();
  return r;
}

constexpr double elbow_ahead = 0.04, hand_behind = 0.11, thumb_behind = 0.15;  // s
/// The hand overshoots by this share of what it is ahead of itself so much later (s), and settles.
constexpr double overshoot = 0.25, settles = 0.22;
constexpr double stroke_behind = 0.14, stick_behind = 0.06;  // s, mean delays
constexpr double greets_after = 0.25, greets_within = 0.50;  // s, after all rests

}  // namespace

void keep_guard(const Figure& figure, const Path& path, const Cues& cues, Track& controls) {
  const double scale = figure.scale();
  const double until = controls.time(controls.count() - 1);
  const Track pose = Track::sample(until, acting_rate, [&](double time) {
    Row now = row(at_ease);
    const auto mix = [&](const Guard& guard, double share) { now += share * (row(guard) - now); };
    if (!cues.swings) return Eigen::VectorXd(now);
    now = row(at_the_belt);
    mix(open, cues.ready(time));
    mix(balancing, cues.braced.at(time)[0]);
    mix(across, cues.winds_up.at(time)[0]);
    mix(chambered, cues.struck(time));
    if (cues.greets())
      mix(greeting, smoothstep((time - cues.rests - greets_after) / greets_within));
    return Eigen::VectorXd(now);
  });
  const Track hand = pose.lagged(hand_behind), later = pose.lagged(settles);
  const Track elbow = pose.ahead(elbow_ahead), thumb = pose.lagged(thumb_behind);
  const Track stroke = Track::sample(until, acting_rate, [&](double time) {
                         return Eigen::VectorXd(path.at(time).position - path.at(0).position);
                       }).lagged(stroke_behind);
  const Track stick = cues.off.smoothed(0.05).lagged(stick_behind);
  const Row ease = row(at_ease);

  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const Row g = hand[i] + overshoot * (hand[i] - later[i]);
    Vec3 wrist(g[1] * std::sin(g[0]), g[2], g[1] * std::cos(g[0]));
    // It balances the right hand, and goes against the free stick.
    const Vec3 f = stroke[i] / scale, s = stick.at(controls.time(i)) / scale;
    wrist += Vec3(soft(-0.22 * f.x(), 0.05), soft(-0.20 * f.y(), 0.07), soft(-0.30 * f.z(), 0.08));
    wrist += Vec3(soft(-0.30 * s.x(), 0.10), soft(-0.20 * s.y(), 0.06), soft(0.30 * s.x(), 0.09));
    auto u = controls.samples().col(i);
    u.segment<3>(guard_x) = scale * wrist;
    u.segment<3>(guard_elbow_x) = elbow[i].segment<3>(3);
    u.segment<3>(guard_thumb_x) = thumb[i].segment<3>(6);
    // The shoulder goes along.
    u[left_shoulder_up] += soft(0.7 * (g[2] - ease[2]), 0.28);
    u[left_shoulder_forward] += soft(0.6 * (wrist.z() - ease[1] * std::cos(ease[0])), 0.22);
  }
}

}  // namespace taut::scenes
