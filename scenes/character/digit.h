// A finger or a thumb as bones and the skin that bends with them.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "scenes/character/skeleton.h"

namespace taut::scenes {

enum class Side { left, right };

/// "LeftHand" or "RightHand", with which the names of a hand's bones begin.
std::string hand_name(Side side);

/// Turns of the three bones of a digit against the hand, in the model's axes at rest.
using DigitTurns = std::array<Quat, 3>;

/// The skin of a bent digit, each vertex with the phalanx that it moves with most. A part for
/// itself is the root, where skin moves mostly with the hand.
struct BentSkin {
  static constexpr std::size_t root = 3, parts = 4;
  struct Ball {  // that holds a part
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };

  std::span<const Vec3> part(std::size_t i) const {
    return std::span(points).subspan(first[i], first[i + 1] - first[i]);
  }

  std::vector<Vec3> points;  // m, part by part
  std::array<std::size_t, parts + 1> first{};
  std::array<Ball, parts> balls;
};

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
  /// The skin when the digit is bent, as it is drawn.
  void bend(const DigitTurns& turns, BentSkin& skin) const;

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
  std::vector<Skin> skin_;                                // by phalanx
  std::array<std::size_t, BentSkin::parts + 1> first_{};  // of each phalanx's
};

}  // namespace taut::scenes
