// Steps of the foot in front.
#include <cmath>

#include "scenes/character/acting.h"

namespace taut {
namespace {

constexpr double settling = 0.25;   // s, over which the hand's place is averaged
constexpr double foresight = 0.45;  // s: the foot is down again before the hand is there
constexpr double share = 1.1;       // of the hand's way
constexpr double worth = 0.06;      // m off, for which it takes a step
constexpr double lasts = 0.34;      // s
constexpr double lift = 0.045;      // m

}  // namespace

Track take_steps(const Track& hand) {
  const Track wanted = hand.smoothed(settling).ahead(foresight);
  Track steps(Eigen::MatrixXd::Zero(3, hand.count()), hand.rate());
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  double start = -lasts;
  for (Eigen::Index i = 0; i < hand.count(); ++i) {
    const double time = hand.time(i);
    if (time >= start + lasts) {
      const Vec3 there = share * Vec3(0.5 * wanted[i][0], 0, wanted[i][2]);
      from = to;
      if ((there - to).norm() > worth) {
        to = there;
        start = time;
      }
    }
    const double t = (time - start) / lasts;
    const bool stands = t >= 1 || to == from;
    const double way = stands ? 1 : t * t * (3 - 2 * t);
    steps.samples().col(i) = from + way * (to - from);
    if (!stands) steps.samples()(1, i) += lift * std::sin(M_PI * t);
  }
  return steps;
}

}  // namespace taut
