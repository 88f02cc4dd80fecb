#include "scenes/character/thumb.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/character/closed_hand.h"
#include "scenes/character/soft.h"

namespace taut::scenes {

Thumb::Thumb(Digit digit, const HandAxes& axes) : digit_(std::move(digit)), axes_(axes) {
  // The thumb's pad faces the palm and the fingers; it flexes to there.
  const Vec3 pad = 0.65 * axes.palm - 0.75 * axes.across;
  hinge_ = (digit_.rest(2) - digit_.rest(1)).cross(pad).normalized();
}

DigitTurns Thumb::lay(std::span<const Capsule> wanted, std::span<const Capsule> things,
                      const Vec3& tip) const {
  Angles best{};
  BentSkin bent;
  double least = std::numeric_limits<double>::infinity();
  for (const double roll : {-1.2, -0.6, 0.0, 0.6, 1.2}) {
    for (const auto& [rise, aside] :
         {std::pair{-0.4, -0.5}, {-0.4, 0.5}, {0.4, -0.5}, {0.4, 0.5}}) {
      Angles x = {rise, aside, roll, 0.6, 0.6};
      // Contacts make narrow valleys: it comes near first, and then they count more and more.
      double cost = 0;
      for (const double firmness : {0.001, 0.01, 0.1, 1.0})
        cost = descend(x, [&](const Angles& trial, double enough) {
          return discomfort(trial, wanted, things, tip, firmness, enough, bent);
        });
      if (cost < least) {
        least = cost;
        best = x;
      }
    }
  }
  return turns(best);
}

DigitTurns Thumb::turns(const Angles& x) const {
  const Quat first = Quat(Eigen::AngleAxisd(x[0], axes_.across)) *
                     Quat(Eigen::AngleAxisd(x[1], axes_.palm)) *
                     Quat(Eigen::AngleAxisd(x[2], axes_.along));
  return chained(first, Quat(Eigen::AngleAxisd(x[3], hinge_)),
                 Quat(Eigen::AngleAxisd(x[4], hinge_)));
}

double Thumb::discomfort(const Angles& x, std::span<const Capsule> wanted,
                         std::span<const Capsule> things, const Vec3& tip, double firmness,
                         double enough, BentSkin& bent) const {
  const DigitTurns turned = turns(x);
  constexpr double rounding = 1e-9;
  if ((1 - rounding) * with_unease(0, x, turned, tip) >= enough) return enough;
  digit_.bend(turned, bent);
  const auto first = wanted.first(1), others = wanted.subspan(1);
  const double middle = gap(bent, 1, first), outer = gap(bent, 2, first);
  double cost = touch(gap(bent, 1, others, middle)) + touch(gap(bent, 2, others, outer));
  if (firmness * cost >= enough) return enough;
  cost += touch(gap(bent, 0, first, std::min(middle, outer)));
  for (const auto& [part, among] :
       {std::pair{std::size_t{0}, wanted}, {BentSkin::root, wanted}, {1, things}, {2, things}}) {
    if (firmness * cost >= enough) return enough;
    cost += 25 * squared((skin_gap - gap(bent, part, among, skin_gap)) / mm);
  }
  return with_unease(firmness * cost, x, turned, tip);
}

double Thumb::with_unease(double cost, const Angles& x, const DigitTurns& turned,
                          const Vec3& tip) const {
  constexpr Angles ease = {0.8, 0.8, 1.2, 0.6, 0.5}, most = {1.1, 1.1, 1.7, 1.1, 1.3};
  for (std::size_t i = 0; i < x.size(); ++i)
    cost += 0.3 * squared(x[i] / ease[i]) + 1e3 * squared(beyond(std::abs(x[i]), most[i]));
  cost += squared((x[3] - x[4]) / 0.4);  // one tendon bends both
  cost += squared((digit_.joints(turned)[3] - tip).norm() / (5 * mm));
  return cost + 1e3 * (squared(beyond(-0.1, x[3])) + squared(beyond(-0.1, x[4])));
}

}  // namespace taut::scenes
