#include "scenes/character/acting.h"

#include <algorithm>
#include <cmath>

#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

// The stance at rest, and where the right hand is at ease; m and rad, for a figure of 1.78 m.
const Vec3 pelvis_at_ease(0.01, -0.080, 0.01);
const Vec3 hand_at_ease(-0.26, 1.06, 0.46);
constexpr double pelvis_turned = 0.55, spine_turned = -0.08;

constexpr double body_lag = 0.110, shoulder_lag = 0.120;  // s, mean delays
constexpr double foresight = 0.22;                        // s, of anticipation
constexpr double breath = 0.27;                           // Hz

}  // namespace

Track act(const Figure& figure, const Path& path, double duration, const Cues& cues) {
  const double scale = figure.scale();
  const Track hand = Track::sample(duration, acting_rate, [&](double time) {
    return Eigen::VectorXd((path.at(time).position - scale * hand_at_ease) / scale);
  });
  const Track velocity = hand.rates();
  const Track body = hand.lagged(body_lag);
  const Track late = hand.lagged(shoulder_lag);
  const Track coming = velocity.smoothed(0.09).ahead(foresight);
  Track speed = velocity;
  speed.samples() = velocity.samples().colwise().norm();
  const Track haste = speed.smoothed(0.3);
  const Track steps = take_steps(hand);

  Eigen::MatrixXd rows(Eigen::Index{control_count}, hand.count());
  for (Eigen::Index i = 0; i < hand.count(); ++i) {
    const Vec3 h = body[i], s = late[i], next = coming[i];
    const Vec3 right = steps[i].head<3>(), left = steps[i].tail<3>();
    const double still = std::exp(-std::pow(haste[i][0] / 0.5, 2));
    const double chest_rise = std::sin(2 * M_PI * breath * hand.time(i)) * (0.35 + 0.65 * still);

    Controls c = Controls::Zero();
    // The weight follows the hand, and sinks before the hand rises; it is between the feet, and
    // while one is up, on the other.
    const Vec3 between = (right + left) / 2;
    Vec3 pelvis = pelvis_at_ease;
    pelvis.x() += soft(0.16 * h.x() - 0.020 * next.x(), 0.07);
    pelvis.x() += 0.6 * between.x() + 0.6 * (right.y() - left.y());
    pelvis.y() += soft(0.10 * h.y() - 0.022 * std::abs(next.y()), 0.06) + 0.003 * chest_rise;
    pelvis.z() += soft(0.20 * h.z() - 0.014 * next.z(), 0.07) + 0.6 * between.z();
    c.segment<3>(root_x) = scale * pelvis;

    // A hand that reaches to the left or forward draws its shoulder along; before it goes there,
    // the torso winds up the other way.
    const double twist =
        soft(0.90 * h.x() + 0.55 * h.z(), 0.45) - soft(0.08 * next.x() + 0.05 * next.z(), 0.14);
    c[pelvis_yaw] = pelvis_turned + 0.35 * twist;
    c[pelvis_lean] = 0.03 + soft(0.06 * h.z(), 0.04);
    c[spine_yaw] = spine_turned + 0.65 * twist;
    c[spine_lean] =
        0.06 + soft(0.30 * h.z() - 0.22 * h.y() + 0.03 * next.y(), 0.18) - 0.018 * chest_rise;
    c[spine_tilt] = soft(-0.30 * h.x() - 0.22 * h.y(), 0.14);

    c[right_shoulder_forward] = soft(0.45 * s.z() + 0.35 * s.x(), 0.25);
    c[right_shoulder_up] = soft(0.55 * s.y(), 0.28) + 0.022 * chest_rise;
    c[left_shoulder_forward] = -0.04 - soft(0.25 * twist, 0.12);
    c[left_shoulder_up] = 0.020 * chest_rise;

    c.segment<3>(right_step_x) = scale * right;
    c.segment<3>(left_step_x) = scale * left;
    rows.col(i) = c;
  }
  Track controls(std::move(rows), acting_rate);
  answer_stick(figure, cues, controls);
  keep_guard(figure, path, cues, controls);
  begin_and_end(figure, cues, controls);
  return controls;
}

}  // namespace taut::scenes
