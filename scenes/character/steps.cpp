// Steps: the foot in front goes where the hand goes, the foot behind is drawn up after it.
#include <algorithm>
#include <cmath>

#include "scenes/character/acting.h"

namespace taut::scenes {
namespace {

constexpr double settling = 0.33;        // s, over which the hand's place is averaged
constexpr double step_foresight = 0.28;  // s: the foot is down again before the hand is there
constexpr double stays = 0.25;           // s: and stands where the hand will be so much later
constexpr double share_ahead = 1.5, share_aside = 0.3;  // of the hand's way
constexpr double apart = 0.2;                           // m: the farthest that a foot goes
constexpr double drawn_up = 0.9;                        // of the way of the foot in front
constexpr double worth = 0.05;                          // m off, for which a foot takes a step
constexpr double lasts = 0.34;                          // s
constexpr double lift = 0.035;                          // m

constexpr double knees_give = 0.18;  // s, before and after a leg would be too short

/// A foot that stands, or goes from where it stood to where it will.
struct Foot {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double start = -lasts;

  bool stands(double time) const { return time >= start + lasts; }
  bool is_off(const Vec3& there) const { return (there - to).norm() > worth; }
  void go(const Vec3& there, double time) {
    from = to;
    to = there;
    start = time;
  }
  Vec3 at(double time) const {
    if (stands(time)) return to;
    const double t = (time - start) / lasts;
    return from + t * t * (3 - 2 * t) * (to - from) + lift * std::sin(M_PI * t) * Vec3::UnitY();
  }
};

}  // namespace

Track take_steps(const Track& hand) {
  const Track settled = hand.smoothed(settling).ahead(step_foresight + lasts);
  const auto wanted = [&](double time) -> Vec3 {
    const Vec3 way = settled.at(time) - settled[0];
    const Vec3 there(share_aside * way.x(), 0, share_ahead * way.z());
    return apart / std::max(apart, there.norm()) * there;
  };
  Track steps(Eigen::MatrixXd::Zero(6, hand.count()), hand.rate());
  Foot right, left;
  for (Eigen::Index i = 0; i < hand.count(); ++i) {
    const double time = hand.time(i);
    // Never both at a time; the one in front goes first.
    if (right.stands(time) && left.stands(time)) {
      const Vec3 behind = drawn_up * right.to;
      if (right.is_off(wanted(time))) {
        right.go(wanted(time + stays), time);
      } else if (left.is_off(behind)) {
        left.go(behind, time);
      }
    }
    steps.samples().col(i) << right.at(time), left.at(time);
  }
  return steps;
}

void sink_to_the_feet(const Figure& figure, Track& controls) {
  Track above(Eigen::MatrixXd(1, controls.count()), acting_rate);
  for (Eigen::Index i = 0; i < controls.count(); ++i)
    above.samples()(0, i) = figure.above_its_feet(controls[i]);
  // Smooth, and nowhere less than it has to be.
  Track widened = above;
  const auto reach = static_cast<Eigen::Index>(knees_give * acting_rate);
  for (Eigen::Index i = 0; i < above.count(); ++i) {
    const Eigen::Index from = std::max<Eigen::Index>(0, i - reach);
    const Eigen::Index until = std::min(above.count() - 1, i + reach);
    widened.samples()(0, i) = above.samples().row(0).segment(from, until - from + 1).maxCoeff();
  }
  controls.samples().row(root_y) -= widened.smoothed(knees_give / 4).samples().row(0);
}

}  // namespace taut::scenes
