#include "render/draw/shading/light_cube.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace taut::draw {

std::array<Mat3, 6> cube_sides() {
  const auto side = [](const Vec3& across, const Vec3& up, const Vec3& ahead) {
    Mat3 m;
    m << across, up, ahead;
    return m;
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  return {side(-z, -y, x), side(z, -y, -x), side(x, z, y),
          side(x, -z, -y), side(x, -y, z),  side(-x, -y, -z)};
}

CubePixel cube_pixel(const Mat3& side, int i, int j, int size) {
  const double s = (2 * i + 1.0) / size - 1, t = (2 * j + 1.0) / size - 1;
  const double square = 1 + s * s + t * t, width = 2.0 / size;
  return {(s * side.col(0) + t * side.col(1) + side.col(2)) / std::sqrt(square),
          width * width / (square * std::sqrt(square)), Vec3::Zero()};
}

Harmonics harmonics(std::span<const CubePixel> cube) {
  HarmonicSum sum;
  for (const CubePixel& p : cube) sum.add(p.direction, p.radiance, p.solid_angle);
  return sum.irradiance();
}

SideLight side_light(std::span<const CubePixel> cube) {
  std::array<Vec3, 6> sum;
  sum.fill(Vec3::Zero());
  for (const CubePixel& p : cube)
    for (int axis = 0; axis < 3; ++axis) {
      const double cosine = p.direction[axis];
      sum[std::size_t(2 * axis + (cosine < 0))] +=
          std::abs(cosine) * p.solid_angle / std::numbers::pi * p.radiance;
    }
  SideLight light;
  for (std::size_t k = 0; k < 6; ++k) light[k] = sum[k].cast<float>();
  return light;
}

CubeMips::CubeMips(std::span<const CubePixel> cube, int size) : size_(size) {
  std::vector<Vec3>& finest = levels_.emplace_back();
  for (const CubePixel& p : cube) finest.push_back(p.radiance);
  for (int wide = size / 2; wide > 0; wide /= 2) {
    const std::vector<Vec3> finer = levels_.back();
    std::vector<Vec3>& level = levels_.emplace_back();
    for (std::size_t row = 0; row < std::size_t(6 * wide); ++row)
      for (std::size_t column = 0; column < std::size_t(wide); ++column) {
        const std::size_t at = 4 * row * std::size_t(wide) + 2 * column;
        const std::size_t below = at + 2 * std::size_t(wide);
        level.push_back((finer[at] + finer[at + 1] + finer[below] + finer[below + 1]) / 4);
      }
  }
}

Vec3 CubeMips::from(const Vec3& direction, double solid_angle) const {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  const std::size_t side = std::size_t(2 * axis + (direction[axis] < 0));
  const Mat3& axes = sides_[side];
  const double ahead = direction.dot(axes.col(2));
  const double s = direction.dot(axes.col(0)) / ahead, t = direction.dot(axes.col(1)) / ahead;
  const double pixels = solid_angle * size_ * size_ * 6 / (4 * std::numbers::pi);
  const int level = std::clamp(int(std::lround(0.5 * std::log2(std::max(pixels, 1.0)))), 0,
                               int(levels_.size()) - 1);
  const int wide = size_ >> level;
  const auto place = [wide](double x) {
    return std::size_t(std::clamp(int((x + 1) / 2 * wide), 0, wide - 1));
  };
  return levels_[std::size_t(level)]
                [(side * std::size_t(wide) + place(t)) * std::size_t(wide) + place(s)];
}

Vec3 CubeMips::blurred(const Vec3& ahead, double roughness) const {
  constexpr int kSamples = 64;
  const double a2 = std::pow(roughness, 4);
  const Vec3 right = ahead.unitOrthogonal(), up = ahead.cross(right);
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double u = (i + 0.5) / kSamples, turn = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
    const double nh2 = (1 - u) / (1 + (a2 - 1) * u);  // of the half vector, squared
    const double nl = 2 * nh2 - 1;
    if (nl <= 0) continue;
    const double d = nh2 * (a2 - 1) + 1;
    const double density = a2 / (std::numbers::pi * d * d) / 4;  // of the direction, 1/sr
    const double out = std::sqrt(1 - nl * nl);
    const Vec3 direction = nl * ahead + out * (std::cos(turn) * right + std::sin(turn) * up);
    sum += nl * from(direction, 1 / (kSamples * density));
    weights += nl;
  }
  return sum / weights;
}

}  // namespace taut::draw
