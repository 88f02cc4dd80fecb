#include "render/film/trails.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {
namespace {

constexpr double kOpacity = 0.85;  // where the point is
constexpr double kOldest = 0.15;   // of its width, at the trail's end
constexpr int kSteps = 4;          // pieces of a curve from one place to the next

std::uint8_t srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double value = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return std::uint8_t(std::lround(255 * value));
}

/// Through place i and the one after it (Catmull and Rom 1974), at the share `u` of the way.
Vec3 on_curve(const std::vector<Vec3>& places, std::size_t i, double u) {
  const Vec3 &b = places[i], &c = places[i + 1];
  const Vec3 a = i > 0 ? places[i - 1] : Vec3(2 * b - c),
             d = i + 2 < places.size() ? places[i + 2] : Vec3(2 * c - b);
  return b + u / 2 * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
}

}  // namespace

void draw_trails(picture::Picture& picture, std::span<const scenes::Trail> trails,
                 const draw::FrameState& instant) {
  const double width = picture.width, height = picture.height;
  for (std::size_t i = 0; i < std::min(trails.size(), instant.trails.size()); ++i) {
    const scenes::Trail& trail = trails[i];
    const auto& [ages, places] = instant.trails[i];
    std::vector<picture::RibbonPoint> points;
    const auto add = [&](double age, const Vec3& place) {
      constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
      const auto at = scenes::on_picture(instant.camera, width / height, place);
      const double young = std::clamp(1 - age / trail.lasts, 0.0, 1.0);
      points.push_back(
          {at ? (1 + at->x()) / 2 * width : kNowhere, at ? (1 - at->y()) / 2 * height : kNowhere,
           trail.width * height * (kOldest + (1 - kOldest) * young), kOpacity * young});
    };
    for (std::size_t k = 0; k + 1 < places.size(); ++k)
      for (int step = 0; step < kSteps; ++step) {
        const double u = double(step) / kSteps;
        add(std::lerp(ages[k], ages[k + 1], u), on_curve(places, k, u));
      }
    if (!places.empty()) add(ages.back(), places.back());
    picture::ribbon(picture, points,
                    {srgb(trail.color.x()), srgb(trail.color.y()), srgb(trail.color.z())});
  }
}

}  // namespace taut::film
