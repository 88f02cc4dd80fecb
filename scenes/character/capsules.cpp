#include "scenes/character/capsules.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/character/skeleton.h"

namespace taut::scenes {
namespace {

constexpr std::size_t fewest = 12;  // vertices that make a bone a body of its own
constexpr double held = 0.98;       // share of them that the capsule holds

/// The distance that a share of `held` does not exceed.
double most(std::vector<double>& distances) {
  const auto rank = static_cast<std::ptrdiff_t>(held * static_cast<double>(distances.size() - 1));
  std::nth_element(distances.begin(), distances.begin() + rank, distances.end());
  return distances[static_cast<std::size_t>(rank)];
}

/// A capsule along `axis` around the middle of the points: a line as thick as they are across it,
/// cut back at its ends by that thickness, then made as thick as the cut line needs.
Capsule fit_along(const std::vector<Vec3>& points, const Vec3& axis) {
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& p : points) {
    const Vec3 local(p.dot(axis), p.dot(u), p.dot(v));
    low = low.cwiseMin(local);
    high = high.cwiseMax(local);
  }
  const Vec3 middle = (low + high) / 2;
  const auto at = [&](double along) -> Vec3 {
    return along * axis + middle.y() * u + middle.z() * v;
  };
  const double thickness = std::max(high.y() - low.y(), high.z() - low.z()) / 2;
  const double half = std::max((high.x() - low.x()) / 2 - thickness, 0.0);
  Capsule capsule{at(middle.x() - half), at(middle.x() + half), 0, 0};
  std::vector<double> distances;
  for (const Vec3& p : points) distances.push_back(point_distance(p, capsule.a, capsule.b));
  capsule.radius = most(distances);
  return capsule;
}

double volume(const Capsule& c) {
  return c.radius * c.radius * ((c.b - c.a).norm() + 4.0 / 3 * c.radius);
}

}  // namespace

double point_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0;
  return (p - a - t * d).norm();
}

std::vector<Capsule> fit_capsules(const Model& model) {
  std::vector<std::vector<Vec3>> skin(model.bones.size());
  for (const Mesh& mesh : model.meshes) {
    for (const Vertex& v : mesh.vertices) {
      const auto strongest = std::max_element(v.weights.begin(), v.weights.end());
      if (!(*strongest > 0)) continue;
      std::size_t bone = v.bones[static_cast<std::size_t>(strongest - v.weights.begin())];
      while (fabric_of(model.bones[bone].name) && model.bones[bone].parent >= 0)
        bone = static_cast<std::size_t>(model.bones[bone].parent);
      skin[bone].emplace_back(v.position[0], v.position[1], v.position[2]);
    }
  }
  std::vector<Capsule> capsules;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    if (skin[i].size() < fewest) continue;
    Capsule best;
    double least = std::numeric_limits<double>::infinity();
    std::vector<Vec3> axes = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    // Limbs lie along their bones: from a joint to the joint of a child.
    const Eigen::Matrix4d own = model.bones[i].inverse_bind.cast<double>();
    for (const Bone& child : model.bones) {
      if (child.parent != static_cast<int>(i) || child.rest.position.norm() < 1e-6) continue;
      axes.push_back(own.topLeftCorner<3, 3>().inverse() * child.rest.position.normalized());
    }
    for (const Vec3& axis : axes) {
      const Capsule trial = fit_along(skin[i], axis.normalized());
      if (volume(trial) < least) {
        least = volume(trial);
        best = trial;
      }
    }
    best.bone = i;
    capsules.push_back(best);
  }
  return capsules;
}

std::vector<Capsule> place_capsules(const std::vector<Capsule>& fitted, const Model& model,
                                    const std::vector<Pose>& bones) {
  std::vector<Capsule> placed = fitted;
  for (Capsule& c : placed) {
    const Eigen::Affine3d bind(model.bones[c.bone].inverse_bind.cast<double>());
    c.a = bones[c.bone].to_world(bind * c.a);
    c.b = bones[c.bone].to_world(bind * c.b);
  }
  return placed;
}

/// Ericson, Real-Time Collision Detection (2005), section 5.1.9: the closest points of two lines,
/// each clamped to its segment in turn.
double segment_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1) {
  const Vec3 d1 = a1 - a0, d2 = b1 - b0, r = a0 - b0;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r);
  constexpr double nothing = 1e-24;
  if (a < nothing) return point_distance(a0, b0, b1);
  if (e < nothing) return point_distance(b0, a0, a1);
  const double b = d1.dot(d2), c = d1.dot(r), determinant = a * e - b * b;
  double s = determinant > nothing ? std::clamp((b * f - c * e) / determinant, 0.0, 1.0) : 0.0;
  double t = (b * s + f) / e;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((b * t - c) / a, 0.0, 1.0);
  }
  return (a0 + s * d1 - b0 - t * d2).norm();
}

double clearance(const Capsule& a, const Capsule& b) {
  return segment_distance(a.a, a.b, b.a, b.b) - a.radius - b.radius;
}

}  // namespace taut::scenes
