#include "render/draw/shading/shadow_cover.h"

#include <algorithm>
#include <array>
#include <limits>

namespace taut::draw {
namespace {

Eigen::AlignedBox3f around(const Places& places, const std::uint32_t* corner) {
  Eigen::AlignedBox3f box(places[corner[0]]);
  return box.extend(places[corner[1]]).extend(places[corner[2]]);
}

/// Whether a triangle overlaps an upright square, seen along z, if their boxes do: no side of it
/// parts them.
bool meets(const std::array<Eigen::Vector2f, 3>& triangle, const Eigen::Vector2f& centre,
           float half) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector2f side = triangle[(k + 1) % 3] - triangle[k];
    const Eigen::Vector2f across(-side.y(), side.x());
    const float width = across.dot(triangle[(k + 2) % 3] - triangle[k]);
    const float at = across.dot(centre - triangle[k]), extent = half * across.lpNorm<1>();
    if (at + extent < std::min(width, 0.0f) || at - extent > std::max(width, 0.0f)) return false;
  }
  return true;
}

}  // namespace

void ShadowCover::start(const Eigen::Matrix4f& light_projection, float filter, float penumbra) {
  projection_ = light_projection;
  filter_ = filter;
  penumbra_ = penumbra;
  nearest_.assign(kCells * kCells, std::numeric_limits<float>::infinity());
  covered_.setEmpty();
}

void ShadowCover::project(const Places& places, Places& projected) const {
  const Eigen::Matrix3f m = projection_.topLeftCorner<3, 3>();
  const Eigen::Vector3f t = projection_.topRightCorner<3, 1>();
  projected.clear();
  for (const Eigen::Vector3f& p : places) projected.emplace_back(m * p + t);
}

void ShadowCover::add(std::span<const std::uint32_t> triangles, std::span<const Places> times) {
  if (triangles.empty()) return;
  projected_.resize(std::max(projected_.size(), times.size()));
  for (std::size_t i = 0; i < times.size(); ++i) project(times[i], projected_[i]);
  const auto cell = [](float at) {  // the first one of what is no number
    return at > 0 ? int(std::min(at * kCells, float(kCells - 1))) : 0;
  };
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    Eigen::AlignedBox3f box;
    for (std::size_t k = 0; k < times.size(); ++k) box.extend(around(projected_[k], &triangles[i]));
    covered_.extend(box);
    for (int y = cell(box.min().y()); y <= cell(box.max().y()); ++y)
      for (int x = cell(box.min().x()); x <= cell(box.max().x()); ++x) {
        float& nearest = nearest_[std::size_t(y * kCells + x)];
        nearest = std::min(nearest, box.min().z());
      }
  }
}

bool ShadowCover::hides(const Places& projected, const std::uint32_t* corner) const {
  const Eigen::AlignedBox3f triangle = around(projected, corner);
  const float filter =
      filter_ + penumbra_ * std::max(triangle.max().z() - covered_.min().z(), 0.0f);
  const float margin = filter + 1.0f / kCells;
  if ((triangle.max().head<2>().array() + margin < covered_.min().head<2>().array()).any() ||
      (triangle.min().head<2>().array() - margin > covered_.max().head<2>().array()).any() ||
      triangle.max().z() <= covered_.min().z())
    return false;
  const Eigen::Array2f low = (triangle.min().head<2>().array() - filter) * float(kCells);
  const Eigen::Array2f high = (triangle.max().head<2>().array() + filter) * float(kCells);
  // So written that what is no number is not hidden.
  if (!(high >= 0).all() || !(low < float(kCells)).all()) return false;
  const Eigen::Array2i first = low.max(0.0f).cast<int>();
  const Eigen::Array2i last = high.min(float(kCells - 1)).cast<int>();
  const std::array sides{Eigen::Vector2f(projected[corner[0]].head<2>()),
                         Eigen::Vector2f(projected[corner[1]].head<2>()),
                         Eigen::Vector2f(projected[corner[2]].head<2>())};
  for (int y = first.y(); y <= last.y(); ++y)
    for (int x = first.x(); x <= last.x(); ++x) {
      if (nearest_[std::size_t(y * kCells + x)] >= triangle.max().z()) continue;
      const Eigen::Vector2f centre((float(x) + 0.5f) / kCells, (float(y) + 0.5f) / kCells);
      if (meets(sides, centre, 0.5f / kCells + filter)) return true;
    }
  return false;
}

Eigen::AlignedBox3f ShadowCover::find(std::span<const std::uint32_t> triangles,
                                      const Places& places,
                                      std::span<const Eigen::AlignedBox3f> boxes,
                                      std::vector<std::uint32_t>& indices) {
  projected_.resize(std::max<std::size_t>(projected_.size(), 1));
  project(places, projected_[0]);
  indices.clear();
  Eigen::AlignedBox3f found;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const std::uint32_t* corner = &triangles[i];
    const bool hidden = hides(projected_[0], corner);
    if (!hidden && boxes.empty()) continue;
    const Eigen::AlignedBox3f box = around(places, corner);
    if (!hidden && std::ranges::none_of(boxes, [&](const auto& b) { return b.intersects(box); }))
      continue;
    indices.insert(indices.end(), corner, corner + 3);
    found.extend(box);
  }
  return found;
}

}  // namespace taut::draw
