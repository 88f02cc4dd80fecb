// Hands: bones and skin of fingers, thumb and palm; a hand closed around a stick, an empty fist.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scenes/character/capsules.h"
#include "scenes/character/skeleton.h"

namespace taut::scenes {

// A finger or a thumb as bones and the skin that bends with them.

enum class Side { left, right };

/// "LeftHand" or "RightHand", with which the names of a hand's bones begin.
std::string hand_name(Side side);

/// Whether a hand has all bones of four fingers and a thumb; one that lacks some is moved as a
/// whole.
bool has_fingers(const Skeleton& skeleton, Side side);

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

// The directions of a hand.

/// The directions of a hand at rest, in the model's axes: from the wrist to the middle knuckle,
/// across it to the thumb's side, and out of the palm. Orthonormal, of either handedness.
struct HandAxes {
  Vec3 along, across, palm;
};

HandAxes hand_axes(const Skeleton& skeleton, Side side);

// The palm's skin, and how near a stick lies to it.

/// Turns of bones against their parents, by bone.
using FingerTurns = std::vector<std::pair<std::size_t, Quat>>;

/// The skin that moves most with a hand's own bone.
class Palm {
 public:
  Palm(const Model& model, const Skeleton& skeleton, std::size_t hand);

  /// Where it is when the fingers are turned so.
  std::vector<Vec3> bent(const FingerTurns& fingers) const;

 private:
  const Skeleton& skeleton_;
  std::vector<Vertex> skin_;
};

/// The least distance of points from a stick's surface, within a finger's breadth of each of the
/// places along it.
std::vector<double> gaps_along(const std::vector<Vec3>& points, const Capsule& stick,
                               std::span<const double> places);

// What brings skin to surfaces: distances between them, their cost, and a search that lowers costs.

inline constexpr double mm = 0.001;
inline constexpr double skin_gap = 0.7 * mm;  // left between skin and what it touches

/// A cost of some numbers that compass search can lower: tries each up and down, and halves the
/// stride when nothing helps. `cost(x, enough)` may stop where it comes to `enough`, which is too
/// much.
template <std::size_t n, typename Cost>
double descend(std::array<double, n>& x, Cost cost, double stride = 0.3, double finest = 0.004) {
  double least = cost(x, std::numeric_limits<double>::infinity());
  while (stride > finest) {
    bool better = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (const double sign : {1.0, -1.0}) {
        std::array<double, n> y = x;
        y[i] += sign * stride;
        const double trial = cost(y, least);
        if (trial < least) {
          x = y;
          least = trial;
          better = true;
        }
      }
    }
    if (!better) stride /= 2;
  }
  return least;
}

/// The cost of a gap (m) between the skin and the surface to touch; penetration costs more.
double touch(double gap);

/// Distance of a point from a capsule's surface; negative inside, m.
double distance(const Vec3& p, const Capsule& c);

/// Distance of a part of the skin from capsules, where it is less than `most` (m).
double gap(const BentSkin& bent, std::size_t part, std::span<const Capsule> things,
           double most = std::numeric_limits<double>::infinity());

// Where a thumb lies.

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

// Fingers that close: how they turn, and how they come to lie side by side.

inline constexpr std::array<const char*, 4> finger_names = {"Index", "Middle", "Ring", "Pinky"};

/// How far a finger's joints are flexed, and how far it leans to the side of the thumb; rad.
struct Flexion {
  std::array<double, 3> joints{};
  double aside = 0;
};

/// Fingers closed round a stick that lies in the palm, or round nothing.
struct ClosedHand {
  FingerTurns fingers;
  std::vector<Capsule> phalanges;  // three a finger, in the order of finger_names
  Capsule stick;                   // longer than any hand is wide
};

/// A digit's turns from those of each joint against the one before.
DigitTurns chained(const Quat& a, const Quat& b, const Quat& c);

/// A finger flexes toward the palm, about the line across it: as far as it leans aside, all of its
/// phalanges do, so that fingers that are closed side by side stay so.
DigitTurns flexed(const Flexion& flexion, const HandAxes& axes);

void add_turns(const Digit& digit, const DigitTurns& turns, FingerTurns& fingers);
/// Its phalanges where those turns bring them.
std::array<Capsule, 3> phalanges_of(const Digit& finger, const DigitTurns& turns);
void add_finger(const Digit& finger, const DigitTurns& turns, ClosedHand& closed);

/// Closes the fingers, in the order of finger_names, each beside the next one nearer to the middle
/// finger until their skins touch. `close` turns a finger that leans so far aside.
ClosedHand close_side_by_side(
    std::span<const Digit> fingers, const HandAxes& axes,
    const std::function<DigitTurns(std::size_t finger, double aside)>& close);

/// Where a held stick lies, in the model's axes at rest, from the hand's joint (m); and the turns
/// of the finger bones that hold it.
struct Grip {
  Vec3 centre, axis;  // the axis is a unit vector out of the thumb's side
  FingerTurns fingers;
};

/// Lays a stick of that radius (m) on the palm, wraps the fingers round it until the skin of their
/// phalanges touches it, and the thumb from the other side. The skin is `model`'s.
/// A hand without fingers has the stick before its palm.
Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius);

// An empty hand, closed.

/// An empty fist, the thumb across the fingers; nothing for a hand without them.
FingerTurns fist(const Model& model, const Skeleton& skeleton, Side side);

}  // namespace taut::scenes
