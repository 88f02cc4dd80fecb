#include "render/draw/jitter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/draw/shading/lighting.h"

namespace taut::draw {
namespace {

constexpr double kSeenTwice = 2;  // px: farther apart, two exposures look like two things

/// The i-th point of a sequence that fills the unit square evenly however far it goes: multiples of
/// the reciprocals of the plastic number (Roberts 2018).
Eigen::Vector2f point(int i) {
  constexpr double kPlastic = 1.32471795724474602596;
  const auto part = [&](double step) {
    const double x = 0.5 + step * i;
    return float(x - std::floor(x));
  };
  return {part(1 / kPlastic), part(1 / (kPlastic * kPlastic))};
}

Eigen::Matrix4f moved_by(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                         const Eigen::Vector2f& pixels) {
  Eigen::Matrix4f moved = view_projection;
  moved.row(0) += 2 * pixels.x() / float(viewport.width) * view_projection.row(3);
  moved.row(1) += 2 * pixels.y() / float(viewport.height) * view_projection.row(3);
  return moved;
}

}  // namespace

std::vector<Exposures> exposures(double way, int samples, int states, double apart) {
  std::vector<Exposures> result;
  const auto enough = [&] { return !result.empty() && result.back().way >= way; };
  if (const int count = samples / 2; count > 1 && count <= states)
    result.push_back({count, count * std::min(apart, kSeenTwice)});
  if (samples > 1 && samples <= states && !enough()) result.push_back({samples, samples * apart});
  int most = samples;
  while (most * apart < way && 2 * most <= states) most *= 2;
  if (most > 2 * samples) result.push_back({2 * samples, 2 * samples * apart});
  if (most > samples) result.push_back({most, most * apart});
  return result;
}

std::size_t shadow_grade(std::span<const Exposures> grades, int samples) {
  std::size_t grade = 1;
  const int enough = std::max(samples, grades.back().count / 4);
  while (grade < grades.size() && grades[grade - 1].count < enough) ++grade;
  return grade;
}

std::size_t casting_grade(std::span<const Exposures> grades, std::size_t grade, int samples) {
  while (grade > 1 && grades[grade - 2].count > samples) --grade;
  return grade;
}

int backdrop_pictures(int samples) {
  return samples == 4 ? 3 : 1;
}

Eigen::Matrix4f moved_backdrop(const Eigen::Matrix4f& view_projection,
                               const picture::Rect& viewport, int i) {
  // Four samples are a quarter of a pixel apart both ways: a third of that makes twelve even rows.
  constexpr float kStep[] = {0, -1.0f / 12, 1.0f / 12};
  return moved_by(view_projection, viewport, {kStep[i], -kStep[i]});
}

Eigen::Matrix4f moved_picture(const Eigen::Matrix4f& view_projection, const picture::Rect& viewport,
                              int i) {
  return moved_by(view_projection, viewport, 0.25f * (point(i).array() - 0.5f));
}

Eigen::Vector2f light_offset(const Eigen::Matrix4f& light_projection, int i) {
  const Eigen::Vector2f p = point(i);
  const float turn = 2 * std::numbers::pi_v<float> * p.x(), out = kSun * std::sqrt(p.y());
  const float metre = light_projection.row(2).head<3>().norm();  // in depths of the map
  return out / metre *
         Eigen::Vector2f(std::cos(turn) * light_projection.row(0).head<3>().norm(),
                         std::sin(turn) * light_projection.row(1).head<3>().norm());
}

Eigen::Matrix4f moved_light(const Eigen::Matrix4f& light_projection, const Vec3& casters, int i) {
  const Eigen::Vector2f offset = light_offset(light_projection, i);
  Eigen::RowVector4f beyond = light_projection.row(2);  // of a point, in depths of the map
  beyond.w() -= light_projection.row(2).dot(casters.cast<float>().homogeneous());
  Eigen::Matrix4f moved = light_projection;
  for (int k = 0; k < 2; ++k) moved.row(k) += offset[k] * beyond;
  return moved;
}

}  // namespace taut::draw
