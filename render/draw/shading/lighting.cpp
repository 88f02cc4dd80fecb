#include "render/draw/shading/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace taut::draw {
namespace {

constexpr double kPi = std::numbers::pi;
/// m, of what a camera sees: of a large scene from farther off.
struct Planes {
  explicit Planes(const scenes::CameraView& camera) {
    const double distance = (camera.target - camera.position).norm();
    far = std::max(60.0, 6 * distance);
    near = std::max(0.05, distance / 200);
  }
  double near, far;
};

double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

Vec3 surrounding_light(const scenes::Light& light, const Vec3& direction) {
  const Vec3 down = light.direction.normalized();
  const double reflected = 0.35 * std::max(-down.y(), 0.0);
  const Vec3 bounce = reflected * light.ground.cwiseProduct(light.color);
  const double above = smoothstep(-0.3, 0.3, direction.y());
  return above * light.sky + (1 - above) * (light.ground + bounce);
}

Vec3 daylight(const scenes::Light& light) {
  const Vec3 luma(0.2126, 0.7152, 0.0722);
  const double sky = luma.dot(light.sky);
  return sky > 0 ? Vec3(luma.dot(light.color) / sky * light.sky) : light.color;
}

void HarmonicSum::add(const Vec3& direction, const Vec3& radiance, double solid_angle) {
  const double x = direction.x(), y = direction.y(), z = direction.z();
  const double basis[] = {1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y};
  for (std::size_t k = 0; k < 9; ++k) sum_[k] += radiance * (basis[k] * solid_angle);
}

Harmonics HarmonicSum::irradiance() const {
  // Squares of the basis functions' norms, times the cosine lobe's 1, 2/3, 1/4 (over pi).
  const double norm[] = {1 / (4 * kPi),  3 / (4 * kPi),  3 / (4 * kPi),
                         3 / (4 * kPi),  15 / (4 * kPi), 15 / (4 * kPi),
                         5 / (16 * kPi), 15 / (4 * kPi), 15 / (16 * kPi)};
  const double lobe[] = {1, 2.0 / 3, 2.0 / 3, 2.0 / 3, 0.25, 0.25, 0.25, 0.25, 0.25};
  Harmonics result;
  for (std::size_t k = 0; k < 9; ++k) result[k] = (sum_[k] * norm[k] * lobe[k]).cast<float>();
  return result;
}

Harmonics ambient_harmonics(const scenes::Light& light) {
  constexpr int kDirections = 2048;
  HarmonicSum sum;
  for (int i = 0; i < kDirections; ++i) {
    // Fibonacci points: even over the sphere.
    const double y = 1 - (2.0 * i + 1) / kDirections, turn = kPi * (3 - std::sqrt(5.0)) * i;
    const double r = std::sqrt(1 - y * y);
    const Vec3 direction(r * std::cos(turn), y, r * std::sin(turn));
    sum.add(direction, surrounding_light(light, direction), 4 * kPi / kDirections);
  }
  return sum.irradiance();
}

std::string light_constants(const scenes::Light& light, const Harmonics& ambient) {
  const auto text = [](const auto& v) {
    return fmt::format("vec3({:.9g}, {:.9g}, {:.9g})", v.x(), v.y(), v.z());
  };
  std::string constants;
  for (const auto& [name, value] : {std::pair("TO_LIGHT", Vec3(-light.direction.normalized())),
                                    {"LIGHT_COLOR", light.color},
                                    {"DAYLIGHT", daylight(light)},
                                    {"SKY", light.sky},
                                    {"RIM", light.rim},
                                    {"GROUND", light.ground}})
    constants += fmt::format("const vec3 {} = {};\n", name, text(value));
  std::string list;
  for (const Eigen::Vector3f& c : ambient) list += (list.empty() ? "" : ", ") + text(c);
  return constants + fmt::format("const vec3 AMBIENT[9] = vec3[9]({});\n", list);
}

LightMap light_map(const Vec3& direction, const Eigen::AlignedBox3d& casters, int resolution) {
  const Vec3 forward = direction.normalized();
  const Vec3 right =
      forward.cross(std::abs(forward.y()) < 0.99 ? Vec3::UnitY() : Vec3::UnitX()).normalized();
  Mat3 axes;  // rows: across, up, along
  axes << right.transpose(), right.cross(forward).transpose(), forward.transpose();

  Eigen::AlignedBox3d box;
  for (int i = 0; i < 8; ++i) box.extend(axes * casters.corner(Eigen::AlignedBox3d::CornerType(i)));
  const double size = std::max(std::ceil(box.sizes().head<2>().maxCoeff() * 2) / 2, 0.5);
  const double texel = size / resolution;
  const Vec3 middle = box.center();
  const double left = (std::floor((middle.x() - size / 2) / texel)) * texel;
  const double bottom = (std::floor((middle.y() - size / 2) / texel)) * texel;
  // Receivers lie beyond the casters; nearer casters are flattened onto the near plane.
  const double near = std::floor(box.min().z()), depth = std::ceil(box.max().z()) - near + 8;

  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.row(0) << axes.row(0) / size, -left / size;
  m.row(1) << axes.row(1) / size, -bottom / size;
  m.row(2) << axes.row(2) / depth, -near / depth;
  return {m.cast<float>(), texel};
}

float penumbra(const Eigen::Matrix4f& light_projection) {
  return kSun * light_projection.row(0).head<3>().norm() / light_projection.row(2).head<3>().norm();
}

Eigen::Matrix4f camera_projection(const scenes::CameraView& camera, double aspect) {
  const Vec3 back = (camera.position - camera.target).normalized();
  const Vec3 right = Vec3::UnitY().cross(back).normalized();
  Mat3 axes;
  axes << right.transpose(), back.cross(right).transpose(), back.transpose();
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = axes;
  view.topRightCorner<3, 1>() = -axes * camera.position;

  const double focal = 1 / std::tan(camera.field_of_view / 2);
  const auto [near, far] = Planes(camera);
  Eigen::Matrix4d lens = Eigen::Matrix4d::Zero();
  lens(0, 0) = focal / aspect;
  lens(1, 1) = focal;
  lens(2, 2) = (far + near) / (near - far);
  lens(2, 3) = 2 * far * near / (near - far);
  lens(3, 2) = -1;
  return (lens * view).cast<float>();
}

gl::Confusion confusion(const scenes::CameraView& camera, int height) {
  constexpr double kSensor = 0.024;  // m, its height
  const double slope = std::tan(camera.field_of_view / 2);
  const double aperture = camera.relative_aperture * kSensor / 2 / slope;  // m, its diameter
  // Rays through the aperture's edge meet on the plane of focus: where depth is z, they are
  // aperture/2 (z/focus - 1) off the middle one.
  const double scale = aperture / 2 / camera.focus * height / (2 * slope);  // px, of 1 - focus/z
  // The buffer's depth is linear in 1/z.
  const auto [near, far] = Planes(camera);
  return {float(scale * (1 - camera.focus / near)), float(scale * (1 - camera.focus / far))};
}

}  // namespace taut::draw
