#include "scenes/character/grip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "scenes/character/capsules.h"

namespace taut {
namespace {

constexpr double degree = M_PI / 180, mm = 0.001;
constexpr double skin = 0.7 * mm;  // left between skin and what it touches
constexpr std::array<const char*, 4> finger_names = {"Index", "Middle", "Ring", "Pinky"};

/// A cost of some angles (rad) that compass search can lower: tries each angle up and down, and
/// halves the stride when nothing helps.
template <std::size_t n, typename Cost>
double descend(std::array<double, n>& x, Cost cost) {
  double least = cost(x);
  for (double stride = 0.3; stride > 0.004;) {
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

double squared(double x) {
  return x * x;
}
double beyond(double value, double limit) {
  return std::max(0.0, value - limit);
}

/// What a gap (m) between skin and what it shall touch costs: entering it costs more.
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

/// Distance of each phalanx's and the root's skin from capsules, the least of it.
std::array<double, 4> gaps(const Digit& digit, const DigitTurns& turns,
                           std::span<const Capsule> things) {
  std::array<double, 4> least;
  least.fill(std::numeric_limits<double>::infinity());
  digit.each_vertex(turns, [&](std::size_t phalanx, const Vec3& p) {
    for (const Capsule& c : things) least[phalanx] = std::min(least[phalanx], distance(p, c));
  });
  return least;
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
  double least = std::numeric_limits<double>::infinity();
  for (const double knuckle : {50 * degree, 72 * degree}) {
    for (const double middle : {55 * degree, 85 * degree}) {
      Angles angles = {knuckle, middle, 35 * degree};
      const double cost = descend(angles, [&](const Angles& x) {
        const auto gap = gaps(finger, flexed(x, hinge), {&stick, 1});
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
          sum += touch(gap[k]) + 1e4 * squared(beyond(x[k], most[k]) + beyond(5 * degree, x[k]));
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

/// Where a thumb lies: it touches one of `wanted` with its two outer phalanges, and enters no
/// thing.
class Thumb {
 public:
  Thumb(Digit digit, const HandAxes& axes) : digit_(std::move(digit)), axes_(axes) {
    // Its pad faces the palm and the fingers; it flexes to there.
    const Vec3 pad = 0.65 * axes.palm - 0.75 * axes.across;
    hinge_ = (digit_.rest(2) - digit_.rest(1)).cross(pad).normalized();
  }

  const Digit& digit() const { return digit_; }

  /// `tip`: where its end would best be.
  DigitTurns lay(std::span<const Capsule> wanted, std::span<const Capsule> things,
                 const Vec3& tip) const {
    Angles best{};
    double least = std::numeric_limits<double>::infinity();
    for (const double roll : {-1.4, -0.7, 0.0, 0.7, 1.4}) {
      for (const double rise : {-0.4, 0.4}) {
        Angles x = {rise, 0, roll, 0.4, 0.4};
        const double cost =
            descend(x, [&](const Angles& trial) { return discomfort(trial, wanted, things, tip); });
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

  double discomfort(const Angles& x, std::span<const Capsule> wanted,
                    std::span<const Capsule> things, const Vec3& tip) const {
    const DigitTurns turned = turns(x);
    const auto near = gaps(digit_, turned, wanted), free = gaps(digit_, turned, things);
    double cost = touch(near[1]) + touch(near[2]);
    for (const double gap : {near[0], near[Digit::root], free[1], free[2]})
      cost += 25 * squared(beyond(skin, gap) / mm);
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

/// The least distance of the hand's own skin, its fingers turned so, from the stick's surface.
double palm_gap(const Model& model, const Skeleton& skeleton, std::size_t hand,
                const std::vector<std::pair<std::size_t, Quat>>& fingers, const Capsule& stick) {
  Posture posture = skeleton.upright();
  for (const auto& [bone, turn] : fingers) posture.turn[bone] = turn;
  const Placement placed = skeleton.place(posture);
  double least = std::numeric_limits<double>::infinity();
  for (const Mesh& mesh : model.meshes) {
    for (const Vertex& v : mesh.vertices) {
      const auto strongest = std::ranges::max_element(v.weights);
      if (*strongest <= 0 ||
          v.bones[static_cast<std::size_t>(strongest - v.weights.begin())] != hand)
        continue;
      const Vec3 rest(v.position[0], v.position[1], v.position[2]);
      Vec3 p = Vec3::Zero();
      for (std::size_t k = 0; k < 4; ++k)
        p += double{v.weights[k]} * (placed.position[v.bones[k]] +
                                     placed.turn[v.bones[k]] * (rest - skeleton.rest(v.bones[k])));
      least = std::min(least, distance(p, stick));
    }
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

ClosedHand close_hand(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 wrist = skeleton.rest(hand);
  const HandAxes axes = hand_axes(skeleton, side);
  const double length = (skeleton.rest(skeleton.find(hand_name(side) + "Middle1")) - wrist).norm();
  constexpr double tilt = 14 * degree;  // to the fingertips, as a fist holds a rod
  const Vec3 axis = std::cos(tilt) * axes.across + std::sin(tilt) * axes.along;
  // A finger flexes toward the palm: about the hinge that turns `along` into `palm`.
  const Vec3 hinge = axes.along.cross(axes.palm);

  ClosedHand closed;
  double height = radius + 0.18 * length;  // over the palm's bones
  // Fingers that close pull the palm's skin along, so that the stick lies a little differently.
  for (int round = 0; round < 3; ++round) {
    const Vec3 centre =
        wrist + 0.77 * length * axes.along - 0.04 * length * axes.across + height * axes.palm;
    closed = {{}, {}, {centre - axis, centre + axis, radius, hand}};
    for (const char* name : finger_names) {
      const Digit finger(model, skeleton, side, name);
      add_finger(finger, wrap(finger, closed.stick, hinge), closed);
    }
    const double gap = palm_gap(model, skeleton, hand, closed.fingers, closed.stick);
    if (round < 2 && std::isfinite(gap)) height += skin - gap;
  }
  return closed;
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
  // The thumb goes round from the other side, beside the index finger.
  const Vec3 beside = closed.phalanges[1].b - centre;
  const double along = beside.dot(axis) + closed.phalanges[1].radius + thumb.digit().radius(2);
  const Vec3 out = (0.8 * axes.palm + 0.6 * axes.along).normalized();
  const Vec3 tip = centre + along * axis + (radius + thumb.digit().radius(2)) * out;
  add_turns(thumb.digit(), thumb.lay({&stick, 1}, closed.phalanges, tip), closed.fingers);
  return {centre - skeleton.rest(stick.bone), axis, std::move(closed.fingers)};
}

std::vector<std::pair<std::size_t, Quat>> fist(const Model& model, const Skeleton& skeleton,
                                               Side side) {
  constexpr std::array<double, 3> curl = {82 * degree, 100 * degree, 65 * degree};
  const HandAxes axes = hand_axes(skeleton, side);
  ClosedHand closed;
  for (const char* name : finger_names) {
    const Digit finger(model, skeleton, side, name);
    add_finger(finger, flexed(curl, axes.along.cross(axes.palm)), closed);
  }
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // Across the middle phalanges of index and middle finger.
  const std::array<Capsule, 2> middles = {closed.phalanges[1], closed.phalanges[4]};
  const Vec3 tip =
      (middles[1].a + middles[1].b) / 2 + (middles[1].radius + thumb.digit().radius(2)) * axes.palm;
  add_turns(thumb.digit(), thumb.lay(middles, closed.phalanges, tip), closed.fingers);
  return closed.fingers;
}

}  // namespace taut
