// Where a thumb lies.
#pragma once

#include <span>

#include "scenes/character/hand_axes.h"
#include "scenes/character/touch.h"

namespace taut::scenes {

/// It touches one of what is wanted with its two outer phalanges, and the first of them with any;
/// it enters no thing.
class Thumb {
 public:
  Thumb(Digit digit, const HandAxes& axes);

  const Digit& digit() const { return digit_; }

  /// `tip`: where its end would best be.
  DigitTurns lay(std::span<const Capsule> wanted, std::span<const Capsule> things,
                 const Vec3& tip) const;

 private:
  using Angles =
      std::array<double, 5>;  // of the first joint about three axes; flexion of the others

  DigitTurns turns(const Angles& x) const;
  /// `firmness`: the weight of contacts. Counts no further than `enough`.
  double discomfort(const Angles& x, std::span<const Capsule> wanted,
                    std::span<const Capsule> things, const Vec3& tip, double firmness,
                    double enough, BentSkin& bent) const;
  /// The cost with that of a thumb turned so, whatever it touches.
  double with_unease(double cost, const Angles& x, const DigitTurns& turned, const Vec3& tip) const;

  Digit digit_;
  HandAxes axes_;
  Vec3 hinge_;
};

}  // namespace taut::scenes
