#include "scenes/character/hand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>

#include "scenes/character/track.h"

namespace taut::scenes {
namespace {

/// Of a hand without fingers: it goes on from the fore arm, the thumb before the palm's edge. At
/// rest palms look down, or to the body beside hanging arms.
HandAxes axes_of_arm(const Skeleton& skeleton, Side side) {
  const std::string name = side == Side::left ? "Left" : "Right";
  HandAxes axes;
  axes.along =
      (skeleton.rest(skeleton.find(name + "Hand")) - skeleton.rest(skeleton.find(name + "ForeArm")))
          .normalized();
  Vec3 front = Vec3::UnitZ();
  if (std::abs(axes.along.z()) > 0.9) front = Vec3::UnitX() * (side == Side::left ? -1 : 1);
  axes.across = (front - front.dot(axes.along) * axes.along).normalized();
  axes.palm = (side == Side::left ? 1 : -1) * axes.along.cross(axes.across);
  return axes;
}

}  // namespace

HandAxes hand_axes(const Skeleton& skeleton, Side side) {
  if (!has_fingers(skeleton, side)) return axes_of_arm(skeleton, side);
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

Palm::Palm(const Model& model, const Skeleton& skeleton, std::size_t hand) : skeleton_(skeleton) {
  for (const Mesh& mesh : model.meshes)
    for (const Vertex& v : mesh.vertices) {
      const auto strongest = std::ranges::max_element(v.weights);
      if (*strongest > 0 &&
          v.bones[static_cast<std::size_t>(strongest - v.weights.begin())] == hand)
        skin_.push_back(v);
    }
}

std::vector<Vec3> Palm::bent(const FingerTurns& fingers) const {
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

double touch(double gap) {
  const double off = (gap - skin_gap) / mm;
  return off > 0 ? squared(off) : 25 * squared(off);
}

double distance(const Vec3& p, const Capsule& c) {
  const Vec3 axis = c.b - c.a, from = p - c.a;
  const double t = std::clamp(from.dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (from - t * axis).norm() - c.radius;
}

double gap(const BentSkin& bent, std::size_t part, std::span<const Capsule> things, double most) {
  const BentSkin::Ball& around = bent.balls[part];
  for (const Capsule& c : things) {
    if (distance(around.centre, c) - around.radius >= most) continue;
    // As distance() has it, but for the root, which the nearest point alone needs.
    const Vec3 axis = c.b - c.a;
    const double length = axis.squaredNorm();
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : bent.part(part)) {
      const Vec3 from = p - c.a;
      const double t = std::clamp(from.dot(axis) / length, 0.0, 1.0);
      nearest = std::min(nearest, (from - t * axis).squaredNorm());
    }
    most = std::min(most, std::sqrt(nearest) - c.radius);
  }
  return most;
}

namespace {

constexpr double usual_radius = 0.008, usual_tip = 0.02;  // m, where there is no skin to measure

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

}  // namespace

std::string hand_name(Side side) {
  return side == Side::left ? "LeftHand" : "RightHand";
}

bool has_fingers(const Skeleton& skeleton, Side side) {
  constexpr double kLeast = 1e-6;  // m, of what has a direction
  const auto bone = [&](const std::string& name) { return skeleton.maybe(hand_name(side) + name); };
  const auto rest = [&](int at) { return skeleton.rest(static_cast<std::size_t>(at)); };
  if (bone("") < 0) return false;
  for (const std::string name : {"Thumb", "Index", "Middle", "Ring", "Pinky"}) {
    const std::array<int, 3> joints = {bone(name + "1"), bone(name + "2"), bone(name + "3")};
    if (std::ranges::min(joints) < 0) return false;
    for (std::size_t k = 0; k < 2; ++k)
      if (!((rest(joints[k]) - rest(joints[k + 1])).norm() > kLeast)) return false;
  }
  const Vec3 along = rest(bone("Middle1")) - rest(bone(""));
  return (rest(bone("Index1")) - rest(bone("Pinky1"))).cross(along).norm() > kLeast * kLeast;
}

Digit::Digit(const Model& model, const Skeleton& skeleton, Side side, const std::string& name) {
  for (std::size_t i = 0; i < 3; ++i) {
    bones_[i] = skeleton.find(hand_name(side) + name + std::to_string(i + 1));
    rest_[i] = skeleton.rest(bones_[i]);
  }
  take_skin(model);
  // The last phalanx has no joint at its end: it goes as far as its skin.
  const Vec3 along = (rest_[2] - rest_[1]).normalized();
  double length = 0;
  for (const Skin& v : skin_)
    if (v.phalanx == 2) length = std::max(length, (v.position - rest_[2]).dot(along));
  rest_[3] = rest_[2] + std::max(length - usual_radius, usual_tip / 2) * along;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> distances;
    for (const Skin& v : skin_)
      if (v.phalanx == k)
        distances.push_back(distance_to_segment(v.position, rest_[k], rest_[k + 1]));
    const auto middle = distances.begin() + std::ssize(distances) / 2;
    if (!distances.empty()) std::nth_element(distances.begin(), middle, distances.end());
    radius_[k] = distances.empty() ? usual_radius : *middle;
  }
  pad_bare_bones();
  std::ranges::stable_sort(skin_, {}, &Skin::phalanx);
  for (const Skin& v : skin_) ++first_[v.phalanx + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

void Digit::take_skin(const Model& model) {
  for (const Mesh& mesh : model.meshes) {
    for (const Vertex& vertex : mesh.vertices) {
      Skin v{Vec3(vertex.position[0], vertex.position[1], vertex.position[2]), {}, 1, 0};
      for (std::size_t i = 0; i < 4; ++i) {
        const auto bone = std::ranges::find(bones_, std::size_t{vertex.bones[i]});
        if (vertex.weights[i] <= 0 || bone == bones_.end()) continue;
        v.weights[static_cast<std::size_t>(bone - bones_.begin())] += double{vertex.weights[i]};
        v.of_hand -= double{vertex.weights[i]};
      }
      if (v.of_hand > 0.5) continue;
      v.phalanx = static_cast<std::size_t>(std::ranges::max_element(v.weights) - v.weights.begin());
      skin_.push_back(v);
    }
  }
}

void Digit::pad_bare_bones() {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::ranges::any_of(skin_, [&](const Skin& v) { return v.phalanx == k; })) continue;
    const Vec3 bone = rest_[k + 1] - rest_[k];
    const Vec3 u = bone.unitOrthogonal(), w = bone.normalized().cross(u);
    Skin v{Vec3::Zero(), {}, 0, k};
    v.weights[k] = 1;
    for (const double share : {0.4, 0.7, 1.0})
      for (int i = 0; i < 8; ++i) {
        const double angle = i * M_PI / 4;
        v.position =
            rest_[k] + share * bone + radius_[k] * (std::cos(angle) * u + std::sin(angle) * w);
        skin_.push_back(v);
      }
  }
}

std::array<Vec3, 4> Digit::joints(const DigitTurns& turns) const {
  std::array<Vec3, 4> at{rest_[0]};
  for (std::size_t k = 0; k < 3; ++k) at[k + 1] = at[k] + turns[k] * (rest_[k + 1] - rest_[k]);
  return at;
}

void Digit::bend(const DigitTurns& turns, BentSkin& skin) const {
  const std::array<Vec3, 4> at = joints(turns);
  std::array<Mat3, 3> turn;
  std::array<Vec3, 3> move;  // of a phalanx: x to turn x + move
  for (std::size_t k = 0; k < 3; ++k) {
    turn[k] = turns[k].toRotationMatrix();
    move[k] = at[k] - turn[k] * rest_[k];
  }
  skin.points.clear();
  skin.first = first_;
  for (const Skin& v : skin_) {
    Vec3 p = v.of_hand * v.position;
    for (std::size_t k = 0; k < 3; ++k)
      if (v.weights[k] > 0) p += v.weights[k] * (turn[k] * v.position + move[k]);
    skin.points.push_back(p);
  }
  for (std::size_t k = 0; k < BentSkin::parts; ++k) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vec3& p : skin.part(k)) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    skin.balls[k] = {(low + high) / 2, (high - low).norm() / 2};
  }
}

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

namespace {

/// How far the outer phalanges' skin is from a neighbour's.
double gap_beside(const Digit& finger, const DigitTurns& turns, std::span<const Capsule> neighbour,
                  BentSkin& bent) {
  finger.bend(turns, bent);
  return std::min(gap(bent, 1, neighbour), gap(bent, 2, neighbour));
}

}  // namespace

DigitTurns chained(const Quat& a, const Quat& b, const Quat& c) {
  return {a, a * b, a * b * c};
}

DigitTurns flexed(const Flexion& flexion, const HandAxes& axes) {
  const Vec3 hinge = axes.along.cross(axes.palm);
  const auto turn = [&](double angle) { return Quat(Eigen::AngleAxisd(angle, hinge)); };
  const auto [a, b, c] = flexion.joints;
  DigitTurns turns = chained(turn(a), turn(b), turn(c));
  if (flexion.aside == 0) return turns;
  const Quat lean(Eigen::AngleAxisd(flexion.aside, axes.along.cross(axes.across)));
  for (Quat& q : turns) q = q * lean;
  return turns;
}

void add_turns(const Digit& digit, const DigitTurns& turns, FingerTurns& fingers) {
  for (std::size_t k = 0; k < 3; ++k)
    fingers.emplace_back(digit.bones()[k], k == 0 ? turns[0] : turns[k - 1].conjugate() * turns[k]);
}

std::array<Capsule, 3> phalanges_of(const Digit& finger, const DigitTurns& turns) {
  const auto at = finger.joints(turns);
  std::array<Capsule, 3> phalanges;
  for (std::size_t k = 0; k < 3; ++k)
    phalanges[k] = {at[k], at[k + 1], finger.radius(k), finger.bones()[k]};
  return phalanges;
}

void add_finger(const Digit& finger, const DigitTurns& turns, ClosedHand& closed) {
  add_turns(finger, turns, closed.fingers);
  const auto phalanges = phalanges_of(finger, turns);
  closed.phalanges.insert(closed.phalanges.end(), phalanges.begin(), phalanges.end());
}

ClosedHand close_side_by_side(
    std::span<const Digit> fingers, const HandAxes& axes,
    const std::function<DigitTurns(std::size_t finger, double aside)>& close) {
  constexpr std::size_t middle = 1;
  constexpr double most = 24 * degree, finest = 0.1 * degree;
  std::array<DigitTurns, finger_names.size()> turns;
  turns[middle] = close(middle, 0);
  BentSkin bent;
  // The middle finger's neighbours, then theirs.
  for (const auto& [finger, neighbour] : {std::pair{0, 1}, {2, 1}, {3, 2}}) {
    const auto i = static_cast<std::size_t>(finger), beside = static_cast<std::size_t>(neighbour);
    const auto phalanges = phalanges_of(fingers[beside], turns[beside]);
    const double side =
        (fingers[beside].rest(0) - fingers[i].rest(0)).dot(axes.across) > 0 ? 1 : -1;
    constexpr double flesh = 0.6 * mm;  // that gives way where fingers press on one another
    double apart = 0, pressed = most;
    while (pressed - apart > finest) {
      const double trial = (apart + pressed) / 2;
      turns[i] = close(i, side * trial);
      (gap_beside(fingers[i], turns[i], phalanges, bent) > -flesh ? apart : pressed) = trial;
    }
    turns[i] = close(i, side * apart);
  }
  ClosedHand closed;
  for (std::size_t i = 0; i < fingers.size(); ++i) add_finger(fingers[i], turns[i], closed);
  return closed;
}

namespace {

/// How a finger that leans so far aside wraps round the stick: all phalanges touch it, as far as
/// joints allow.
Flexion wrap(const Digit& finger, double aside, const Capsule& stick, const HandAxes& axes) {
  using Angles = std::array<double, 3>;
  constexpr Angles most = {88 * degree, 108 * degree, 75 * degree};
  Angles best{};
  BentSkin bent;
  double least = std::numeric_limits<double>::infinity();
  for (const double knuckle : {50 * degree, 65 * degree, 80 * degree}) {
    for (const double middle : {25 * degree, 55 * degree, 90 * degree}) {
      Angles angles = {knuckle, middle, 35 * degree};
      const double cost = descend(angles, [&](const Angles& x, double enough) {
        finger.bend(flexed({x, aside}, axes), bent);
        double sum = 0;
        for (std::size_t k = 0; k < 3 && sum < enough; ++k)
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
  return {best, aside};
}

/// Where a stick's axis passes index and little finger's roots: along the hand and over its bones,
/// m.
using Place = std::array<double, 4>;

/// The stick lies where the fingers begin, across the palm, so far over the bones that
/// the skin touches it.
ClosedHand close_hand(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 wrist = skeleton.rest(hand);
  const HandAxes axes = hand_axes(skeleton, side);
  const double length = (skeleton.rest(skeleton.find(hand_name(side) + "Middle1")) - wrist).norm();
  std::vector<Digit> fingers;
  for (const char* name : finger_names) fingers.emplace_back(model, skeleton, side, name);

  const double index = (fingers.front().rest(0) - wrist).dot(axes.across);
  const double little = (fingers.back().rest(0) - wrist).dot(axes.across);
  const auto stick_at = [&](const Place& x) {
    const Vec3 a = wrist + x[0] * axes.along + index * axes.across + x[1] * axes.palm;
    const Vec3 b = wrist + x[2] * axes.along + little * axes.across + x[3] * axes.palm;
    const Vec3 axis = (a - b).normalized();
    const Vec3 centre = a - index / axis.dot(axes.across) * axis;
    return Capsule{centre - axis, centre + axis, radius, hand};
  };
  const Palm palm(model, skeleton, hand);
  // Nearer the wrist, knuckles would have to fold too far. At the thumb it is nearer to the
  // fingertips, as a fist holds a rod.
  constexpr double ahead = 0.825, behind = 0.65;
  const Place best = {ahead * length, radius + 0.18 * length, behind * length,
                      radius + 0.18 * length};
  Place x = best;
  ClosedHand closed;
  // Fingers that close pull the palm's skin along, so that the stick lies a little differently.
  for (int round = 0;; ++round) {
    closed = {{}, {}, stick_at(x)};
    for (const Digit& finger : fingers)
      add_finger(finger, flexed(wrap(finger, 0, closed.stick, axes), axes), closed);
    const std::vector<Vec3> points = palm.bent(closed.fingers);
    if (round == 3 || points.empty()) break;
    const auto cost = [&](const Place& trial, double) {
      const Capsule stick = stick_at(trial);
      const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
      std::vector<double> places;
      for (const Digit& finger : fingers) places.push_back((finger.rest(0) - centre).dot(axis));
      double sum = squared((trial[0] - best[0]) / mm) + squared((trial[2] - best[2]) / mm);
      for (const double gap : gaps_along(points, stick, places))
        if (std::isfinite(gap)) sum += touch(gap);
      return sum;
    };
    descend(x, cost, 10 * mm, 0.1 * mm);
  }
  const Capsule stick = closed.stick;
  closed = close_side_by_side(fingers, axes, [&](std::size_t i, double aside) {
    return flexed(wrap(fingers[i], aside, stick, axes), axes);
  });
  closed.stick = stick;
  return closed;
}

/// Where a stick lies in a hand without fingers: a hand is a third as long as the fore arm.
Grip before_palm(const Skeleton& skeleton, Side side, double radius) {
  const HandAxes axes = hand_axes(skeleton, side);
  const std::string name = side == Side::left ? "Left" : "Right";
  const double arm =
      (skeleton.rest(skeleton.find(name + "Hand")) - skeleton.rest(skeleton.find(name + "ForeArm")))
          .norm();
  constexpr double along = 0.32, thickness = 0.057;
  return {arm * along * axes.along + (radius + arm * thickness) * axes.palm, axes.across, {}};
}

}  // namespace

Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  if (!has_fingers(skeleton, side)) return before_palm(skeleton, side, radius);
  const HandAxes axes = hand_axes(skeleton, side);
  ClosedHand closed = close_hand(model, skeleton, side, radius);
  const Capsule& stick = closed.stick;
  const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // The thumb goes round from the other side, on the side of the chain, and over the end of the
  // index finger: towards its middle phalanx, as far as it reaches.
  constexpr double beside = 14 * mm, back = 0.2;
  const Capsule& end = closed.phalanges[2];
  const Vec3 over = (1 - back) * end.a + back * closed.phalanges[1].a + beside * axis;
  const Vec3 off = over - centre;
  const Vec3 out = (off - off.dot(axis) * axis).normalized();
  const Vec3 tip = over + 0.6 * (end.radius + thumb.digit().radius(2)) * out;  // close beside it
  std::vector<Capsule> things = closed.phalanges;
  things.push_back(stick);
  const std::array<Capsule, 3> wanted = {stick, closed.phalanges[1], end};
  add_turns(thumb.digit(), thumb.lay(wanted, things, tip), closed.fingers);
  return {centre - skeleton.rest(stick.bone), axis, std::move(closed.fingers)};
}

namespace {

/// How far a finger is flexed whose joints turn together, as its tendons turn them.
Flexion curled(double share, double aside) {
  return {{share * 88 * degree, share * 116 * degree, share * 78 * degree}, aside};
}

/// The share at which the finger's end touches the palm's skin; a short finger's presses on it.
double curl(const Digit& finger, double aside, std::span<const Vec3> palm, const HandAxes& axes) {
  constexpr double least = 0.88, step = 0.005;
  constexpr double near = 1.5 * mm;  // half as far as vertices of the skin are from one another
  BentSkin bent;
  double share = least;
  for (; share + step <= 1; share += step) {
    finger.bend(flexed(curled(share + step, aside), axes), bent);
    double apart = std::numeric_limits<double>::infinity();
    for (const Vec3& p : bent.part(2))
      for (const Vec3& q : palm) apart = std::min(apart, (p - q).squaredNorm());
    if (apart < squared(near)) break;
  }
  return share;
}

}  // namespace

FingerTurns fist(const Model& model, const Skeleton& skeleton, Side side) {
  if (!has_fingers(skeleton, side)) return {};
  const HandAxes axes = hand_axes(skeleton, side);
  const Palm palm(model, skeleton, skeleton.find(hand_name(side)));
  std::vector<Digit> fingers;
  for (const char* name : finger_names) fingers.emplace_back(model, skeleton, side, name);
  std::array<double, finger_names.size()> share;
  share.fill(0.9);
  ClosedHand closed;
  // Fingers that close pull the palm's skin along, and lean aside.
  for (int round = 0;; ++round) {
    std::array<double, finger_names.size()> leaning{};
    closed = close_side_by_side(fingers, axes, [&](std::size_t i, double aside) {
      leaning[i] = aside;
      return flexed(curled(share[i], aside), axes);
    });
    if (round == 2) break;
    const std::vector<Vec3> skin = palm.bent(closed.fingers);
    for (std::size_t i = 0; i < fingers.size(); ++i)
      share[i] = curl(fingers[i], leaning[i], skin, axes);
  }
  const Thumb thumb(Digit(model, skeleton, side, "Thumb"), axes);
  // Across the middle phalanges of index and middle finger, as far as it reaches.
  const std::array<Capsule, 2> middles = {closed.phalanges[1], closed.phalanges[4]};
  const Vec3 across = middles[1].a - middles[0].a;
  // Nearer to the outer joint, so that the thumb crosses them.
  const Vec3 tip = middles[1].a + 0.9 * (middles[1].b - middles[1].a) + across / 2 +
                   (middles[1].radius + thumb.digit().radius(2)) * axes.palm;
  add_turns(thumb.digit(), thumb.lay(middles, closed.phalanges, tip), closed.fingers);
  return closed.fingers;
}

}  // namespace taut::scenes
