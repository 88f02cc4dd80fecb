#include "scenes/character/grip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "scenes/character/capsules.h"
#include "scenes/character/soft.h"

namespace taut::scenes {
namespace {

constexpr double mm = 0.001;
constexpr double skin = 0.7 * mm;  // left between skin and what it touches
constexpr std::array<const char*, 4> finger_names = {"Index", "Middle", "Ring", "Pinky"};

/// A cost of some numbers that compass search can lower: tries each up and down, and halves the
/// stride when nothing helps.
template <std::size_t n, typename Cost>
double descend(std::array<double, n>& x, Cost cost, double stride = 0.3, double finest = 0.004) {
  double least = cost(x);
  while (stride > finest) {
    bool better = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (const double sign : {1.0, -1.0}) {
        std::array<double, n> y = x;
        y[i] += sign * stride;
        const double trial = cost(y);
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
double touch(double gap) {
  const double off = (gap - skin) / mm;
  return off > 0 ? squared(off) : 25 * squared(off);
}

/// Distance of a point from a capsule's surface; negative inside, m.
double distance(const Vec3& p, const Capsule& c) {
  const Vec3 axis = c.b - c.a, from = p - c.a;
  const double t = std::clamp(from.dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (from - t * axis).norm() - c.radius;
}

/// Distance of a part of the skin from capsules, where it is less than `most` (m).
double gap(const BentSkin& bent, std::size_t part, std::span<const Capsule> things,
           double most = std::numeric_limits<double>::infinity()) {
  const BentSkin::Ball& around = bent.balls[part];
  for (const Capsule& c : things) {
    if (distance(around.centre, c) - around.radius >= most) continue;
    for (const Vec3& p : bent.part(part)) most = std::min(most, distance(p, c));
  }
  return most;
}

/// A digit's turns from those of each joint against the one before.
DigitTurns chained(const Quat& a, const Quat& b, const Quat& c) {
  return {a, a * b, a * b * c};
}

DigitTurns flexed(const std::array<double, 3>& angles, const Vec3& hinge) {
  const auto turn = [&](double angle) { return Quat(Eigen::AngleAxisd(angle, hinge)); };
  return chained(turn(angles[0]), turn(angles[1]), turn(angles[2]));
}

void add_turns(const Digit& digit, const DigitTurns& turns,
               std::vector<std::pair<std::size_t, Quat>>& fingers) {
  for (std::size_t k = 0; k < 3; ++k)
    fingers.emplace_back(digit.bones()[k], k == 0 ? turns[0] : turns[k - 1].conjugate() * turns[k]);
}

/// Turns that wrap a finger round the stick: all phalanges touch it, as far as joints allow.
DigitTurns wrap(const Digit& finger, const Capsule& stick, const Vec3& hinge) {
  using Angles = std::array<double, 3>;
  constexpr Angles most = {88 * degree, 108 * degree, 75 * degree};
  Angles best{};
  BentSkin bent;
  double least = std::numeric_limits<double>::infinity();
  for (const double knuckle : {50 * degree, 72 * degree}) {
    for (const double middle : {55 * degree, 85 * degree}) {
      Angles angles = {knuckle, middle, 35 * degree};
      const double cost = descend(angles, [&](const Angles& x) {
        finger.bend(flexed(x, hinge), bent);
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
          sum += touch(gap(bent, k, {&stick, 1})) +
                 1e4 * squared(beyond(x[k], most[k]) + beyond(5 * degree, x[k]));
        return sum;
      });
      if (cost < least) {
        least = cost;
        best = angles;
      }
    }
  }
  return flexed(best, hinge);
}

/// Turns that close a finger on itself: its joints turn together, as its tendons turn them, until
/// its end touches the palm's skin.
DigitTurns curl(const Digit& finger, std::span<const Vec3> palm, const Vec3& out,
                const Vec3& hinge) {
  constexpr std::array<double, 3> closed = {86 * degree, 104 * degree, 62 * degree};
  constexpr double least = 0.75, step = 0.005, beside = 6 * mm;
  BentSkin bent;
  DigitTurns turns;
  for (double share = least; share <= 1; share += step) {
    const DigitTurns trial =
        flexed({share * closed[0], share * closed[1], share * closed[2]}, hinge);
    finger.bend(trial, bent);
    double height = std::numeric_limits<double>::infinity();  // of the finger's end over the palm
    for (const Vec3& p : bent.part(2))
      for (const Vec3& q : palm) {
        const Vec3 off = p - q;
        const double over = off.dot(out);
        if ((off - over * out).norm() < beside) height = std::min(height, over);
      }
    if (share > least && height < skin) break;
    turns = trial;
  }
  return turns;
}

/// Where a thumb lies: it touches one of `wanted` with its two outer phalanges, and enters no
/// thing.
class Thumb {
 public:
  Thumb(Digit digit, const HandAxes& axes) : digit_(std::move(digit)), axes_(axes) {
    // The thumb's pad faces the palm and the fingers; it flexes to there.
    const Vec3 pad = 0.65 * axes.palm - 0.75 * axes.across;
    hinge_ = (digit_.rest(2) - digit_.rest(1)).cross(pad).normalized();
  }

  const Digit& digit() const { return digit_; }

  /// `tip`: where its end would best be.
  DigitTurns lay(std::span<const Capsule> wanted, std::span<const Capsule> things,
                 const Vec3& tip) const {
    Angles best{};
    BentSkin bent;
    double least = std::numeric_limits<double>::infinity();
    for (const double roll : {-0.7, 0.0, 0.7}) {
      for (const double rise : {-0.4, 0.4}) {
        Angles x = {rise, 0, roll, 0.6, 0.6};
        // Contacts make narrow valleys: it comes near first, and then they count more and more.
        double cost = 0;
        for (const double firmness : {0.001, 0.01, 0.1, 1.0})
          cost = descend(x, [&](const Angles& trial) {
            return discomfort(trial, wanted, things, tip, firmness, bent);
          });
        if (cost < least) {
          least = cost;
          best = x;
        }
      }
    }
    return turns(best);
  }

 private:
  using Angles =
      std::array<double, 5>;  // of the first joint about three axes; flexion of the others

  DigitTurns turns(const Angles& x) const {
    const Quat first = Quat(Eigen::AngleAxisd(x[0], axes_.across)) *
                       Quat(Eigen::AngleAxisd(x[1], axes_.palm)) *
                       Quat(Eigen::AngleAxisd(x[2], axes_.along));
    return chained(first, Quat(Eigen::AngleAxisd(x[3], hinge_)),
                   Quat(Eigen::AngleAxisd(x[4], hinge_)));
  }

  /// `firmness`: the weight of contacts.
  double discomfort(const Angles& x, std::span<const Capsule> wanted,
                    std::span<const Capsule> things, const Vec3& tip, double firmness,
                    BentSkin& bent) const {
    const DigitTurns turned = turns(x);
    digit_.bend(turned, bent);
    double cost = touch(gap(bent, 1, wanted)) + touch(gap(bent, 2, wanted));
    for (const double free : {gap(bent, 0, wanted, skin), gap(bent, BentSkin::root, wanted, skin),
                              gap(bent, 1, things, skin), gap(bent, 2, things, skin)})
      cost += 25 * squared((skin - free) / mm);
    cost *= firmness;
    constexpr Angles ease = {0.8, 0.8, 1.2, 0.8, 0.8}, most = {1.1, 1.1, 1.7, 1.1, 1.3};
    for (std::size_t i = 0; i < x.size(); ++i)
      cost += 0.3 * squared(x[i] / ease[i]) + 1e3 * squared(beyond(std::abs(x[i]), most[i]));
    cost += squared((digit_.joints(turned)[3] - tip).norm() / (5 * mm));
    return cost + 1e3 * (squared(beyond(-0.1, x[3])) + squared(beyond(-0.1, x[4])));
  }

  Digit digit_;
  HandAxes axes_;
  Vec3 hinge_;
};

/// The skin that moves most with a hand's own bone.
class Palm {
 public:
  Palm(const Model& model, const Skeleton& skeleton, std::size_t hand) : skeleton_(skeleton) {
    for (const Mesh& mesh : model.meshes)
      for (const Vertex& v : mesh.vertices) {
        const auto strongest = std::ranges::max_element(v.weights);
        if (*strongest > 0 &&
            v.bones[static_cast<std::size_t>(strongest - v.weights.begin())] == hand)
          skin_.push_back(v);
      }
  }

  /// Where it is when the fingers are turned so.
  std::vector<Vec3> bent(const std::vector<std::pair<std::size_t, Quat>>& fingers) const {
    Posture posture = skeleton_.upright();
    for (const auto& [bone, turn] : fingers) posture.turn[bone] = turn;
    const Placement placed = skeleton_.place(posture);
    std::vector<Vec3> points;
    for (const Vertex& v : skin_) {
      const Vec3 rest(v.position[0], v.position[1], v.position[2]);
      Vec3 p = Vec3::Zero();
      for (std::size_t k = 0; k < 4; ++k)
        p += double{v.weights[k]} * (placed.position[v.bones[k]] +
                                     placed.turn[v.bones[k]] * (rest - skeleton_.rest(v.bones[k])));
      points.push_back(p);
    }
    return points;
  }

 private:
  const Skeleton& skeleton_;
  std::vector<Vertex> skin_;
};

/// The least distance of points from a stick's surface, within a finger's breadth of each of the
/// places along it.
std::vector<double> gaps_along(const std::vector<Vec3>& points, const Capsule& stick,
                               std::span<const double> places) {
  constexpr double half = 8 * mm;
  const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
  std::vector<double> least(places.size(), std::numeric_limits<double>::infinity());
  for (const Vec3& p : points) {
    const double at = (p - centre).dot(axis);
    for (std::size_t k = 0; k < places.size(); ++k)
      if (std::abs(at - places[k]) < half) least[k] = std::min(least[k], distance(p, stick));
  }
  return least;
}

/// Fingers closed round a stick that lies in the palm.
struct ClosedHand {
  std::vector<std::pair<std::size_t, Quat>> fingers;
  std::vector<Capsule> phalanges;  // three a finger
  Capsule stick;                   // longer than any hand is wide
};

void add_finger(const Digit& finger, const DigitTurns& turns, ClosedHand& closed) {
  add_turns(finger, turns, closed.fingers);
  const auto at = finger.joints(turns);
  for (std::size_t k = 0; k < 3; ++k)
    closed.phalanges.push_back({at[k], at[k + 1], finger.radius(k), finger.bones()[k]});
}

/// The stick lies where the fingers begin, so far over the bones that the palm's skin touches it.
ClosedHand close_hand(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 wrist = skeleton.rest(hand);
  const HandAxes axes = hand_axes(skeleton, side);
  const double length = (skeleton.rest(skeleton.find(hand_name(side) + "Middle1")) - wrist).norm();
  constexpr double tilt = 14 * degree;  // to the fingertips, as a fist holds a rod
  const Vec3 axis = std::cos(tilt) * axes.across + std::sin(tilt) * axes.along;
  // A finger flexes toward the palm: about the hinge that turns `along` into `palm`.
  const Vec3 hinge = axes.along.cross(axes.palm);
  std::vector<Digit> fingers;
  for (const char* name : finger_names) fingers.emplace_back(model, skeleton, side, name);

  using Place = std::array<double, 2>;  // m, along the hand and over its bones
  const auto stick_at = [&](const Place& x) {
    const Vec3 centre = wrist + x[0] * axes.along - 0.04 * length * axes.across + x[1] * axes.palm;
    return Capsule{centre - axis, centre + axis, radius, hand};
  };
  const Palm palm(model, skeleton, hand);
  const double best = 0.75 * length;  // nearer the wrist, knuckles would have to fold too far
  Place x = {best, radius + 0.18 * length};
  ClosedHand closed;
  // Fingers that close pull the palm's skin along, so that the stick lies a little differently.
  for (int round = 0;; ++round) {
    closed = {{}, {}, stick_at(x)};
    for (const Digit& finger : fingers)
      add_finger(finger, wrap(finger, closed.stick, hinge), closed);
    const std::vector<Vec3> points = palm.bent(closed.fingers);
    if (round == 3 || points.empty()) return closed;
    const auto cost = [&](const Place& trial) {
      const Capsule stick = stick_at(trial);
      const Vec3 centre = (stick.a + stick.b) / 2;
      std::vector<double> places;
      for (const Digit& finger : fingers) places.push_back((finger.rest(0) - centre).dot(axis));
      double sum = squared((trial[0] - best) / mm);
      for (const double gap : gaps_along(points, stick, places))
        if (std::isfinite(gap)) sum += touch(gap);
      return sum;
    };
    descend(x, cost, 10 * mm, 0.1 * mm);
  }
}

}  // namespace

HandAxes hand_axes(const Skeleton& skeleton, Side side) {
  const auto joint = [&](const char* name) {
    return skeleton.rest(skeleton.find(hand_name(side) + name));
  };
  const Vec3 wrist = joint("");
  HandAxes axes;
  axes.along = (joint("Middle1") - wrist).normalized();
  const Vec3 across = joint("Index1") - joint("Pinky1");
  axes.across = (across - across.dot(axes.along) * axes.along).normalized();
  axes.palm = axes.along.cross(axes.across);
  // Thumbs lie before the palm.
  if (axes.palm.dot(joint("Thumb3") - wrist) < 0) axes.palm = -axes.palm;
  return axes;
}

Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const HandAxes axes = hand_axes(skeleton, side);
  ClosedHand closed = close_hand(model, skeleton, side, radius);
  const Capsule& stick = closed.stick;
  const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // The thumb goes round from the other side and lies on the stick before the index finger's end:
  // on a circle about the stick, so far on that the two touch.
  const Capsule& end = closed.phalanges[2];
  const auto across = [&](const Vec3& v) -> Vec3 { return v - v.dot(axis) * axis; };
  const Vec3 off = across(end.b - centre), onward = across(end.b - end.a);
  const double width = thumb.digit().radius(2), apart = end.radius + width + skin;
  const double far = off.norm(), near = radius + width + skin;
  const double turn = std::acos(
      std::clamp((squared(far) + squared(near) - squared(apart)) / (2 * far * near), -1.0, 1.0));
  const double sense = off.cross(onward).dot(axis) < 0 ? -1 : 1;
  const Vec3 tip = end.b - off + near / far * (Eigen::AngleAxisd(sense * turn, axis) * off);
  const std::array<Capsule, 2> index = {end, stick};
  std::vector<Capsule> things = closed.phalanges;
  things.push_back(stick);
  add_turns(thumb.digit(), thumb.lay(index, things, tip), closed.fingers);
  return {centre - skeleton.rest(stick.bone), axis, std::move(closed.fingers)};
}

std::vector<std::pair<std::size_t, Quat>> fist(const Model& model, const Skeleton& skeleton,
                                               Side side) {
  const HandAxes axes = hand_axes(skeleton, side);
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 hinge = axes.along.cross(axes.palm);
  const std::vector<Vec3> palm = Palm(model, skeleton, hand).bent({});
  ClosedHand closed;
  for (const char* name : finger_names) {
    const Digit finger(model, skeleton, side, name);
    add_finger(finger, curl(finger, palm, axes.palm, hinge), closed);
  }
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // Across the middle phalanges of index and middle finger.
  const std::array<Capsule, 2> middles = {closed.phalanges[1], closed.phalanges[4]};
  const Vec3 tip =
      (middles[1].a + middles[1].b) / 2 + (middles[1].radius + thumb.digit().radius(2)) * axes.palm;
  add_turns(thumb.digit(), thumb.lay(middles, closed.phalanges, tip), closed.fingers);
  return closed.fingers;
}

}  // namespace taut::scenes
