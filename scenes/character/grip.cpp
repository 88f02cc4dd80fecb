#include "scenes/character/grip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace taut {
namespace {

constexpr double degree = M_PI / 180;
constexpr double skin = 0.0005;  // m, left between skin and stick
constexpr std::array<const char*, 4> finger_names = {"Index", "Middle", "Ring", "Pinky"};

std::string hand_name(Side side) {
  return side == Side::left ? "LeftHand" : "RightHand";
}

std::array<std::size_t, 3> joints(const Skeleton& skeleton, Side side, const char* finger) {
  std::array<std::size_t, 3> bones{};
  for (std::size_t i = 0; i < 3; ++i)
    bones[i] = skeleton.find(hand_name(side) + finger + std::to_string(i + 1));
  return bones;
}

/// Rest positions of the vertices that move mostly with `bone`.
std::vector<Vec3> skin_of(const Model& model, std::size_t bone) {
  std::vector<Vec3> points;
  for (const Mesh& mesh : model.meshes) {
    for (const Vertex& v : mesh.vertices) {
      const auto strongest = std::max_element(v.weights.begin(), v.weights.end());
      if (*strongest > 0.5f &&
          v.bones[static_cast<std::size_t>(strongest - v.weights.begin())] == bone)
        points.emplace_back(v.position[0], v.position[1], v.position[2]);
    }
  }
  return points;
}

/// A stick's axis, without ends.
struct Line {
  Vec3 point, axis;
  double distance(const Vec3& p) const { return (p - point).cross(axis).norm(); }
};

/// The phalanx between a joint and the next, in skin and bone.
struct Phalanx {
  std::size_t bone;
  Vec3 joint, end;  // rest
  std::vector<Vec3> points;
  double radius;  // median distance of the skin from the bone
};

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

std::vector<Phalanx> finger_of(const Model& model, const Skeleton& skeleton, Side side,
                               const char* name) {
  const auto bones = joints(skeleton, side, name);
  std::vector<Phalanx> finger;
  for (std::size_t i = 0; i < 3; ++i) {
    Phalanx p{bones[i], skeleton.rest(bones[i]), Vec3::Zero(), skin_of(model, bones[i]), 0.008};
    // The last phalanx has no joint at its end: it goes as far as its skin.
    const Vec3 along = i < 2 ? (skeleton.rest(bones[i + 1]) - p.joint).normalized().eval()
                             : (p.joint - skeleton.rest(bones[1])).normalized().eval();
    double length = i < 2 ? (skeleton.rest(bones[i + 1]) - p.joint).norm() : 0.02;
    if (i == 2 && !p.points.empty()) {
      length = 0;
      for (const Vec3& q : p.points) length = std::max(length, (q - p.joint).dot(along));
      length = std::max(length - p.radius, 0.01);
    }
    p.end = p.joint + length * along;
    if (!p.points.empty()) {
      std::vector<double> distances;
      for (const Vec3& q : p.points) distances.push_back(distance_to_segment(q, p.joint, p.end));
      const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
      std::nth_element(distances.begin(), middle, distances.end());
      p.radius = *middle;
    }
    finger.push_back(std::move(p));
  }
  return finger;
}

/// How far the skin of `phalanx`, its joint at `joint` and turned, stays from the stick's axis.
double clearance(const Phalanx& phalanx, const Line& stick, const Vec3& joint, const Quat& turn) {
  double least = std::numeric_limits<double>::infinity();
  const Vec3 bone = phalanx.end - phalanx.joint;
  const auto at = [&](const Vec3& p) -> Vec3 { return joint + turn * (p - phalanx.joint); };
  for (const Vec3& p : phalanx.points) {
    // The root of a phalanx lies at its joint however the joint turns; it decides nothing.
    if ((p - phalanx.joint).dot(bone) > 0.3 * bone.squaredNorm())
      least = std::min(least, stick.distance(at(p)));
  }
  if (phalanx.points.empty())
    for (const double t : {0.4, 0.7, 1.0})
      least = std::min(least, stick.distance(at(phalanx.joint + t * bone)) - phalanx.radius);
  return least;
}

/// Angles of the three joints of a finger about `hinge` that bring each phalanx to the stick.
std::array<double, 3> close_finger(const std::vector<Phalanx>& finger, const Line& stick,
                                   const Vec3& hinge, double radius) {
  constexpr std::array<double, 3> limit = {88 * degree, 108 * degree, 75 * degree};
  std::array<double, 3> angles{};
  Vec3 joint = finger[0].joint;
  double total = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    constexpr double step = 0.5 * degree;
    const auto turn = [&](double angle) { return Quat(Eigen::AngleAxisd(total + angle, hinge)); };
    while (angles[i] + step < limit[i] &&
           clearance(finger[i], stick, joint, turn(angles[i] + step)) > radius + skin)
      angles[i] += step;
    total += angles[i];
    joint += turn(0) * (finger[i].end - finger[i].joint);
  }
  return angles;
}

/// The thumb: angles of the first joint about three axes, and the flexion of the other two.
using ThumbAngles = std::array<double, 5>;

struct Thumb {
  std::vector<Phalanx> bones;
  HandAxes axes;
  Vec3 hinge;  // of flexion

  std::array<Quat, 3> turns(const ThumbAngles& x) const {
    const Quat first = Quat(Eigen::AngleAxisd(x[0], axes.across)) *
                       Quat(Eigen::AngleAxisd(x[1], axes.palm)) *
                       Quat(Eigen::AngleAxisd(x[2], axes.along));
    return {first, Quat(Eigen::AngleAxisd(x[3], hinge)), Quat(Eigen::AngleAxisd(x[4], hinge))};
  }

  /// Lower is better: both outer phalanges touch the stick, the first bone stays clear of it, the
  /// tip lies beyond the index finger, and no joint turns far.
  double cost(const ThumbAngles& x, const Line& stick, double radius) const {
    const auto local = turns(x);
    double cost = 0;
    Quat turn = Quat::Identity();
    Vec3 joint = bones[0].joint;
    for (std::size_t i = 0; i < 3; ++i) {
      turn = turn * local[i];
      const double gap = clearance(bones[i], stick, joint, turn) - radius - skin;
      if (i > 0) cost += std::abs(gap) * (gap > 0 ? 60 : 300);
      if (i == 0) cost += std::max(0.0, -gap) * 300;
      joint += turn * (bones[i].end - bones[i].joint);
    }
    const double along_stick = (joint - stick.point).dot(stick.axis);
    cost += 20 * std::abs(along_stick - 0.030);
    const Vec3 outward = (joint - stick.point - along_stick * stick.axis).normalized();
    cost += 2.5 * (1 - outward.dot((0.8 * axes.palm + 0.6 * axes.along).normalized()));
    constexpr ThumbAngles ease = {1.0, 0.8, 0.6, 0.9, 1.0};
    for (std::size_t i = 0; i < x.size(); ++i) cost += 0.1 * std::abs(x[i]) / ease[i];
    constexpr double most[2] = {1.0, 1.3};
    for (std::size_t i = 0; i < 2; ++i)
      cost += 3 * (std::max(0.0, x[3 + i] - most[i]) + std::max(0.0, -x[3 + i]));
    return cost;
  }
};

/// Compass search: tries each angle up and down, and halves the stride when nothing helps.
ThumbAngles lay_thumb(const Thumb& thumb, const Line& stick, double radius) {
  ThumbAngles best{};
  double least = std::numeric_limits<double>::infinity();
  for (const double start : {-0.6, 0.0, 0.6}) {
    ThumbAngles x = {0, 0, start, 0.3, 0.3};
    double cost = thumb.cost(x, stick, radius);
    for (double stride = 0.4; stride > 0.002;) {
      bool better = false;
      for (std::size_t i = 0; i < x.size(); ++i) {
        for (const double sign : {1.0, -1.0}) {
          ThumbAngles y = x;
          y[i] += sign * stride;
          const double trial = thumb.cost(y, stick, radius);
          if (trial < cost) {
            x = y;
            cost = trial;
            better = true;
          }
        }
      }
      if (!better) stride /= 2;
    }
    if (cost < least) {
      least = cost;
      best = x;
    }
  }
  return best;
}

}  // namespace

HandAxes hand_axes(const Skeleton& skeleton, Side side) {
  const Vec3 wrist = skeleton.rest(skeleton.find(hand_name(side)));
  const Vec3 middle = skeleton.rest(joints(skeleton, side, "Middle")[0]);
  const Vec3 index = skeleton.rest(joints(skeleton, side, "Index")[0]);
  const Vec3 pinky = skeleton.rest(joints(skeleton, side, "Pinky")[0]);
  const Vec3 thumb = skeleton.rest(joints(skeleton, side, "Thumb")[2]);
  HandAxes axes;
  axes.along = (middle - wrist).normalized();
  const Vec3 across = index - pinky;
  axes.across = (across - across.dot(axes.along) * axes.along).normalized();
  axes.palm = axes.along.cross(axes.across);
  if (axes.palm.dot(thumb - wrist) < 0) axes.palm = -axes.palm;  // thumbs lie before the palm
  return axes;
}

Grip grip_stick(const Model& model, const Skeleton& skeleton, Side side, double radius) {
  const std::size_t hand = skeleton.find(hand_name(side));
  const Vec3 wrist = skeleton.rest(hand);
  const HandAxes axes = hand_axes(skeleton, side);
  const double length = (skeleton.rest(joints(skeleton, side, "Middle")[0]) - wrist).norm();

  Line stick;
  constexpr double tilt = 14 * degree;  // to the fingertips, as a fist holds a rod
  stick.axis = std::cos(tilt) * axes.across + std::sin(tilt) * axes.along;
  // From above the palm down to its skin.
  const Vec3 over = wrist + 0.81 * length * axes.along - 0.04 * length * axes.across;
  double depth = radius + 0.18 * length;
  const std::vector<Vec3> palm = skin_of(model, hand);
  if (!palm.empty()) {
    depth = radius;
    for (const Vec3& p : palm) {
      const Vec3 offset = p - over;
      const Vec3 across_axis = offset - offset.dot(stick.axis) * stick.axis;
      const double height = across_axis.dot(axes.palm);
      const double aside = (across_axis - height * axes.palm).norm();
      const double r = radius + skin;
      if (aside < r) depth = std::max(depth, height + std::sqrt(r * r - aside * aside));
    }
  }
  stick.point = over + depth * axes.palm;

  Grip grip{stick.point - wrist, stick.axis, {}};
  // A finger flexes toward the palm: about the hinge that turns `along` into `palm`.
  const Vec3 hinge = axes.along.cross(axes.palm);
  for (const char* name : finger_names) {
    const auto finger = finger_of(model, skeleton, side, name);
    const auto angles = close_finger(finger, stick, hinge, radius);
    for (std::size_t i = 0; i < 3; ++i)
      grip.fingers.emplace_back(finger[i].bone, Eigen::AngleAxisd(angles[i], hinge));
  }
  Thumb thumb{finger_of(model, skeleton, side, "Thumb"), axes, Vec3::Zero()};
  thumb.hinge = (thumb.bones[1].end - thumb.bones[1].joint).cross(axes.palm).normalized();
  const auto turns = thumb.turns(lay_thumb(thumb, stick, radius));
  for (std::size_t i = 0; i < 3; ++i) grip.fingers.emplace_back(thumb.bones[i].bone, turns[i]);
  return grip;
}

std::vector<std::pair<std::size_t, Quat>> fist(const Skeleton& skeleton, Side side) {
  constexpr std::array<double, 3> curl = {72 * degree, 95 * degree, 55 * degree};
  const HandAxes axes = hand_axes(skeleton, side);
  const Vec3 hinge = axes.along.cross(axes.palm);
  std::vector<std::pair<std::size_t, Quat>> turns;
  for (const char* name : finger_names) {
    const auto bones = joints(skeleton, side, name);
    for (std::size_t i = 0; i < 3; ++i)
      turns.emplace_back(bones[i], Eigen::AngleAxisd(curl[i], hinge));
  }
  // The thumb lies across the middle phalanges.
  const auto thumb = joints(skeleton, side, "Thumb");
  const Vec3 bend =
      (skeleton.rest(thumb[2]) - skeleton.rest(thumb[1])).cross(axes.palm).normalized();
  const double handed = axes.along.cross(axes.across).dot(axes.palm);
  turns.emplace_back(thumb[0], Quat(Eigen::AngleAxisd(0.5 * handed, axes.palm)) *
                                   Quat(Eigen::AngleAxisd(0.8 * handed, axes.along)));
  turns.emplace_back(thumb[1], Eigen::AngleAxisd(0.6, bend));
  turns.emplace_back(thumb[2], Eigen::AngleAxisd(0.7, bend));
  return turns;
}

}  // namespace taut
