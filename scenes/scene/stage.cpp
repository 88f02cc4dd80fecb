#include "scenes/scene/stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace taut::scenes {
namespace {

constexpr double kNearest = 0.05;  // m, of the focus

/// The rate of change of a key's `member` through its neighbours, zero at the first and the last,
/// so that the camera starts and stops gently.
template <typename Member>
auto rate(std::span<const CameraKey> keys, std::size_t i, Member member) {
  const auto at = [&](std::size_t k) { return std::invoke(member, keys[k]); };
  using Value = std::decay_t<decltype(at(0))>;
  if (i == 0 || i + 1 == keys.size()) return Value(at(i) * 0.0);
  return Value((at(i + 1) - at(i - 1)) / (keys[i + 1].time - keys[i - 1].time));
}

/// The cubic through keys i and i + 1 with those rates, at the share `u` of the way.
template <typename Member>
auto between(std::span<const CameraKey> keys, std::size_t i, double u, Member member) {
  const double dt = keys[i + 1].time - keys[i].time, v = 1 - u;
  const auto a = std::invoke(member, keys[i]), b = std::invoke(member, keys[i + 1]);
  using Value = std::decay_t<decltype(a)>;
  return Value(v * v * (1 + 2 * u) * a + u * u * (3 - 2 * u) * b +
               u * v * dt * (v * rate(keys, i, member) - u * rate(keys, i + 1, member)));
}

double focus_of(const CameraKey& key) {
  return key.focus.value_or((key.target - key.position).norm());
}

/// The keys about i and i + 1 that all have an orbit, and the place of i among them; none where
/// one of these two has none.
std::pair<std::span<const CameraKey>, std::size_t> orbit_around(std::span<const CameraKey> keys,
                                                                std::size_t i) {
  if (!keys[i].orbit || !keys[i + 1].orbit) return {};
  std::size_t first = i, end = i + 2;
  while (first > 0 && keys[first - 1].orbit) --first;
  while (end < keys.size() && keys[end].orbit) ++end;
  return {keys.subspan(first, end - first), i - first};
}

}  // namespace

Vec3 on_orbit(const Vec3& orbit) {
  const double level = orbit.z() * std::cos(orbit.y());
  return {level * std::sin(orbit.x()), orbit.z() * std::sin(orbit.y()),
          level * std::cos(orbit.x())};
}

CameraView camera_at(const std::vector<CameraKey>& keys, double time) {
  const auto after = std::ranges::upper_bound(keys, time, {}, &CameraKey::time);
  const auto next = static_cast<std::size_t>(after - keys.begin());
  if (next == 0 || next == keys.size()) {
    const CameraKey& key = next == 0 ? keys.front() : keys.back();
    return {key.position, key.target, key.field_of_view, key.relative_aperture, focus_of(key)};
  }
  const std::size_t i = next - 1;
  const double u = (time - keys[i].time) / (keys[next].time - keys[i].time);
  const std::span<const CameraKey> all = keys;
  CameraView view{between(all, i, u, &CameraKey::position), between(all, i, u, &CameraKey::target),
                  between(all, i, u, &CameraKey::field_of_view),
                  std::max(between(all, i, u, &CameraKey::relative_aperture), 0.0),
                  std::max(between(all, i, u, focus_of), kNearest)};
  view.moves = keys[i].position != keys[next].position || keys[i].target != keys[next].target ||
               keys[i].field_of_view != keys[next].field_of_view ||
               keys[i].orbit != keys[next].orbit;
  if (const auto [round, at] = orbit_around(all, i); !round.empty())
    view.position =
        view.target +
        on_orbit(between(round, at, u, [](const CameraKey& key) { return *key.orbit; }));
  return view;
}

std::vector<std::string> left_out(const Stage& stage) {
  std::vector<std::string> lines;
  for (const auto* models : {&stage.scenery, &stage.body_models, &stage.characters}) {
    for (const auto& model : *models) {
      if (!model) continue;
      for (const std::string& line : model->left_out) {
        if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
      }
    }
  }
  return lines;
}

std::optional<Eigen::Vector2d> on_picture(const CameraView& camera, double aspect,
                                          const Vec3& point) {
  const Vec3 ahead = (camera.target - camera.position).normalized();
  const Vec3 up = std::abs(ahead.y()) > 0.999 ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
  const Vec3 right = ahead.cross(up).normalized(), to = point - camera.position;
  const double far = to.dot(ahead), half = std::tan(camera.field_of_view / 2);
  if (!(far > 0)) return std::nullopt;
  return Eigen::Vector2d(to.dot(right) / (far * half * aspect),
                         to.dot(right.cross(ahead)) / (far * half));
}

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
