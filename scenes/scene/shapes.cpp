#include "scenes/scene/shapes.h"

#include <array>
#include <cmath>
#include <numbers>

namespace taut::scenes {

namespace {

constexpr int kSides = 48;

std::array<float, 3> as_floats(const Vec3& v) {
  const Eigen::Vector3f f = v.cast<float>();
  return {f.x(), f.y(), f.z()};
}

/// A direction around the y axis; the last side is the first one again, to the bit.
Vec3 around(int side) {
  const double angle = 2 * std::numbers::pi * (side % kSides) / kSides;
  return {std::cos(angle), 0, -std::sin(angle)};
}

Model with_mesh(const char* name, Mesh mesh, const Vec3& color) {
  mesh.name = name;
  Model model;
  model.name = name;
  model.materials.push_back({.name = name, .base_color = as_floats(color)});
  model.meshes.push_back(std::move(mesh));
  return model;
}

}  // namespace

std::uint32_t add_vertex(Mesh& mesh, const Vec3& position, const Vec3& normal) {
  Vertex vertex;
  vertex.position = as_floats(position);
  vertex.normal = as_floats(normal);
  mesh.vertices.push_back(vertex);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.indices.insert(mesh.indices.end(), {a, b, c, a, c, d});
}

Model cylinder_model(double length, double diameter, const Vec3& color) {
  Mesh mesh;
  const Vec3 top(0, length / 2, 0);
  for (int side = 0; side <= kSides; ++side) {
    const Vec3 out = around(side), rim = diameter / 2 * out;
    add_vertex(mesh, rim - top, out);
    const std::uint32_t upper = add_vertex(mesh, rim + top, out);
    if (side > 0) add_quad(mesh, upper - 3, upper - 1, upper, upper - 2);
  }
  for (const double end : {-1.0, 1.0}) {
    const std::uint32_t centre = add_vertex(mesh, end * top, end * Vec3::UnitY());
    for (int side = 0; side <= kSides; ++side) {
      const std::uint32_t rim =
          add_vertex(mesh, end * top + diameter / 2 * around(side), end * Vec3::UnitY());
      if (side == 0) continue;
      const auto [a, b] = end > 0 ? std::pair(rim - 1, rim) : std::pair(rim, rim - 1);
      mesh.indices.insert(mesh.indices.end(), {centre, a, b});
    }
  }
  return with_mesh("cylinder", std::move(mesh), color);
}

Model sphere_model(double diameter, const Vec3& color) {
  constexpr int rings = kSides / 2;
  Mesh mesh;
  for (int ring = 0; ring <= rings; ++ring) {
    const double polar = std::numbers::pi * ring / rings;  // from the lower pole
    const double radius = ring % rings == 0 ? 0 : std::sin(polar);
    for (int side = 0; side <= kSides; ++side) {
      const Vec3 out = radius * around(side) - std::cos(polar) * Vec3::UnitY();
      const std::uint32_t here = add_vertex(mesh, diameter / 2 * out, out);
      if (ring == 0 || side == 0) continue;
      const std::uint32_t below = here - (kSides + 1);
      add_quad(mesh, below - 1, below, here, here - 1);
    }
  }
  return with_mesh("sphere", std::move(mesh), color);
}

Model box_model(const Vec3& size, const Vec3& color) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double end : {-1.0, 1.0}) {
      const Vec3 out = end * Vec3::Unit(axis);
      // u, v and out are right-handed: u to v turns counter-clockwise seen from outside.
      const Vec3 u = Vec3::Unit((axis + 1) % 3), v = out.cross(u);
      std::uint32_t corner = 0;
      for (const auto& [s, t] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
        corner = add_vertex(mesh, 0.5 * size.cwiseProduct(out + s * u + t * v), out);
      }
      add_quad(mesh, corner - 3, corner - 2, corner - 1, corner);
    }
  }
  return with_mesh("box", std::move(mesh), color);
}

}  // namespace taut::scenes
