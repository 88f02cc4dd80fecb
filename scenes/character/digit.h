// A finger or a thumb as bones and the skin that bends with them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scenes/character/skeleton.h"

namespace taut::scenes {

enum class Side { left, right };

/// "LeftHand" or "RightHand", with which the names of a hand's bones begin.
std::string hand_name(Side side);

/// Turns of the three bones of a digit against the hand, in the model's axes at rest.
using DigitTurns = std::array<Quat, 3>;

class Digit {
 public:
  /// `name`: Index, Middle, Ring, Pinky or Thumb. A model without skin there gets some of the usual
  /// thickness. Throws BadAsset when a bone is missing.
  Digit(const Model& model, const Skeleton& skeleton, Side side, const std::string& name);

  const std::array<std::size_t, 3>& bones() const { return bones_; }
  /// Rest position of a phalanx's joint; the fourth is the digit's end (m).
  const Vec3& rest(std::size_t i) const { return rest_[i]; }
  /// Half a phalanx's thickness, m.
  double radius(std::size_t i) const { return radius_[i]; }

  /// Joints and end where those turns bring them, the hand being at rest.
  std::array<Vec3, 4> joints(const DigitTurns& turns) const;
  /// Stands for a phalanx where skin moves mostly with the hand.
  static constexpr std::size_t root = 3;
  /// Calls use(phalanx, position) for every vertex of the bent skin, as it is drawn; the phalanx is
  /// the one that it moves with most, or the digit's root.
  template <typename Use>
  void each_vertex(const DigitTurns& turns, Use use) const {
    const std::array<Vec3, 4> at = joints(turns);
    for (const Skin& v : skin_) {
      Vec3 p = v.of_hand * v.position;
      for (std::size_t k = 0; k < 3; ++k)
        if (v.weights[k] > 0) p += v.weights[k] * (at[k] + turns[k] * (v.position - rest_[k]));
      use(v.phalanx, p);
    }
  }

 private:
  struct Skin {
    Vec3 position;                  // at rest
    std::array<double, 3> weights;  // of the phalanges
    double of_hand;                 // the rest of its weight
    std::size_t phalanx;
  };
  void take_skin(const Model& model);
  void pad_bare_bones();

  std::array<std::size_t, 3> bones_{};
  std::array<Vec3, 4> rest_;
  std::array<double, 3> radius_{};
  std::vector<Skin> skin_;
};

}  // namespace taut::scenes
