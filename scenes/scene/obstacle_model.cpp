#include "scenes/scene/obstacle_model.h"

#include <cmath>
#include <numbers>

#include "scenes/scene/shapes.h"

namespace taut::scenes {

namespace {

constexpr int kQuarter = 12;  // pieces of a quarter of a circle
constexpr double kStep = std::numbers::pi / 2 / kQuarter;

/// All points nearer than `radius` to a box that reaches `inner` from the origin: its corners are
/// eighths of a ball.
Mesh rounded_box(const Vec3& inner, double radius) {
  Mesh mesh;
  const int rings = 2 * (kQuarter + 1), sides = 4 * (kQuarter + 1);
  for (int ring = 0; ring < rings; ++ring) {
    const bool upper = ring > kQuarter;
    const double height = (ring - kQuarter - (upper ? 1 : 0)) * kStep;
    for (int side = 0; side <= sides; ++side) {
      const int quarter = side % sides / (kQuarter + 1);
      const double turn = (side % sides - quarter) * kStep;
      const Vec3 out(std::cos(height) * std::cos(turn), std::sin(height),
                     -std::cos(height) * std::sin(turn));
      const Vec3 corner(quarter == 0 || quarter == 3 ? inner.x() : -inner.x(),
                        upper ? inner.y() : -inner.y(), quarter < 2 ? -inner.z() : inner.z());
      const std::uint32_t here = add_vertex(mesh, corner + radius * out, out);
      if (ring == 0 || side == 0) continue;
      const std::uint32_t below = here - static_cast<std::uint32_t>(sides) - 1;
      add_quad(mesh, below - 1, below, here, here - 1);
    }
  }
  for (const double end : {-1.0, 1.0}) {
    std::uint32_t last = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const double x = corner == 0 || corner == 3 ? inner.x() : -inner.x();
      const double z = (corner < 2 ? -end : end) * inner.z();
      last = add_vertex(mesh, Vec3(x, end * (inner.y() + radius), z), end * Vec3::UnitY());
    }
    add_quad(mesh, last - 3, last - 2, last - 1, last);
  }
  return mesh;
}

/// A cylinder whose rims are rounded.
Mesh rounded_cylinder(const Shape& shape) {
  Mesh mesh;
  const int sides = 4 * kQuarter;
  const double radius = shape.radius - shape.rounding, half = shape.length / 2 - shape.rounding;
  const auto ring = [&](double from_axis, double height, double up, bool first) {
    for (int side = 0; side <= sides; ++side) {
      const double turn = side % sides * kStep;
      const Vec3 around(std::cos(turn), 0, -std::sin(turn));
      const std::uint32_t here = add_vertex(mesh, from_axis * around + height * Vec3::UnitY(),
                                            std::cos(up) * around + std::sin(up) * Vec3::UnitY());
      if (first || side == 0) continue;
      const std::uint32_t below = here - static_cast<std::uint32_t>(sides) - 1;
      add_quad(mesh, below - 1, below, here, here - 1);
    }
  };
  ring(0, -half - shape.rounding, -std::numbers::pi / 2, true);
  for (int step = -kQuarter; step <= 0; ++step) {
    ring(radius + shape.rounding * std::cos(step * kStep),
         -half + shape.rounding * std::sin(step * kStep), step * kStep, false);
  }
  for (int step = 0; step <= kQuarter; ++step) {
    ring(radius + shape.rounding * std::cos(step * kStep),
         half + shape.rounding * std::sin(step * kStep), step * kStep, false);
  }
  ring(0, half + shape.rounding, std::numbers::pi / 2, false);
  return mesh;
}

Mesh square(double size) {
  Mesh mesh;
  for (const auto& [x, z] : {std::pair(-1, 1), {1, 1}, {1, -1}, {-1, -1}}) {
    add_vertex(mesh, Vec3(x * size / 2, 0, z * size / 2), Vec3::UnitY());
  }
  add_quad(mesh, 0, 1, 2, 3);
  return mesh;
}

Mesh mesh_of(const Shape& shape, double size) {
  switch (shape.kind) {
    case Shape::Kind::plane:
      return square(size);
    case Shape::Kind::sphere:
      return rounded_box(Vec3::Zero(), shape.radius);
    case Shape::Kind::capsule:
      return rounded_box(Vec3(0, shape.length / 2, 0), shape.radius);
    case Shape::Kind::cylinder:
      return shape.rounding > 0
                 ? rounded_cylinder(shape)
                 : cylinder_model(shape.length, 2 * shape.radius, Vec3::Ones()).meshes.front();
    case Shape::Kind::box:
      break;
  }
  return shape.rounding > 0
             ? rounded_box(shape.size / 2 - Vec3::Constant(shape.rounding), shape.rounding)
             : box_model(shape.size, Vec3::Ones()).meshes.front();
}

}  // namespace

Model obstacle_model(const Shape& shape, double size, const Pose& place, const Vec3& color) {
  Mesh mesh = mesh_of(shape, size);
  mesh.name = "obstacle";
  for (Vertex& vertex : mesh.vertices) {
    const auto turned = [&](const std::array<float, 3>& v) {
      return Vec3(place.rotation * Vec3(double(v[0]), double(v[1]), double(v[2])));
    };
    const Vec3 position = place.position + turned(vertex.position), normal = turned(vertex.normal);
    for (std::size_t i = 0; i < 3; ++i) {
      vertex.position[i] = static_cast<float>(position[static_cast<Eigen::Index>(i)]);
      vertex.normal[i] = static_cast<float>(normal[static_cast<Eigen::Index>(i)]);
    }
  }
  const Eigen::Vector3f linear = color.cast<float>();
  Model model;
  model.name = "obstacle";
  model.materials.push_back(
      {.name = "obstacle", .base_color = {linear.x(), linear.y(), linear.z()}});
  model.meshes.push_back(std::move(mesh));
  return model;
}

}  // namespace taut::scenes
