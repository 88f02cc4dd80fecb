#include "sim/world/body.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/rotation.h"

namespace taut {
namespace {

/// Inertia of a point mass at `r` about the origin.
Mat3 point_inertia(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
}

}  // namespace

MassProperties solid_cylinder(double mass, double length, double diameter) {
  const double along = mass * diameter * diameter / 8;
  const double across = along / 2 + mass * length * length / 12;
  return {mass, Vec3::Zero(), Vec3(across, along, across).asDiagonal()};
}

MassProperties solid_sphere(double mass, double diameter) {
  return {mass, Vec3::Zero(), mass * diameter * diameter / 10 * Mat3::Identity()};
}

MassProperties solid_box(double mass, const Vec3& size) {
  const Vec3 s = size.cwiseAbs2();
  const Vec3 inertia(s.y() + s.z(), s.z() + s.x(), s.x() + s.y());
  return {mass, Vec3::Zero(), (mass / 12 * inertia).asDiagonal()};
}

MassProperties with_point_mass(const MassProperties& body, double mass, const Vec3& point) {
  const double total = body.mass + mass;
  if (!(total > 0)) return body;
  const Vec3 arm = point - body.centre;
  return {total, body.centre + mass / total * arm,
          body.inertia + point_inertia(body.mass * mass / total, arm)};
}

std::array<Vec3, 6> box_ends(const MassProperties& body) {
  // With half sides a, b, c the moment about the first axis is m (b^2 + c^2) / 3, and so on round.
  const auto [moments, axes] = principal_axes(body.inertia);
  std::array<Vec3, 6> ends;
  for (int i = 0; i < 3; ++i) {
    const double others = moments.sum() - 2 * moments[i];
    const double half = std::sqrt(std::max(0.0, 1.5 * others / body.mass));
    for (const int side : {0, 1}) {
      ends[static_cast<std::size_t>(2 * i + side)] =
          body.centre + (side == 0 ? -half : half) * axes.col(i);
    }
  }
  return ends;
}

void reweigh(Body& body, const MassProperties& properties) {
  body.velocity = body.point_velocity(properties.centre);
  body.position = body.point(properties.centre);
  body.mass_properties = properties;
}

FrameMotion driven_frame(const Body& body, double time) {
  FrameMotion frame = body.path->at(time);
  const PointMotion origin = frame.point(-body.grip);
  frame.position = origin.position;
  frame.velocity = origin.velocity;
  frame.acceleration = origin.acceleration;
  return frame;
}

}  // namespace taut
