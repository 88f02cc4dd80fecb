#include "render/draw/swept_shadows.h"

#include <algorithm>
#include <cmath>

namespace taut::draw {
namespace {

constexpr int kMostRoom = 4;       // layers as large as the map
constexpr int kMarginTexels = 16;  // texels that a look-up may lie off a penumbra

picture::Rect widened(const picture::Rect& part, int by, int size) {
  return picture::intersection(
      {part.x - by, part.y - by, part.width + 2 * by, part.height + 2 * by}, {0, 0, size, size});
}

}  // namespace

SweptShadows::SweptShadows(StageParts& parts, const MotionExtents& extents,
                           std::span<const FrameState> shutter, std::span<const Exposures> grades,
                           int samples, const FrameBlock& block, const picture::Rect& changing,
                           const picture::Rect& casters)
    : parts_(parts),
      extents_(extents),
      shutter_(shutter),
      grades_(grades),
      block_(block),
      changing_(changing) {
  const int size = parts.map.size();
  const int reach = int(std::ceil(block.penumbra * float(size))) + kMarginTexels;
  const picture::Rect part = widened(casters, 2 * reach, size);
  count_ = std::min(grades[shadow_grade(grades, samples) - 1].count, int(kLayers));
  while (count_ > kMostRoom &&
         std::int64_t(count_) * part.width * part.height > std::int64_t(kMostRoom) * size * size)
    count_ /= 2;
  parts.map.start_layers(part, count_);
  const picture::Rect within = widened(casters, reach, size);
  block_.layered = Eigen::Vector4f(float(within.x), float(within.y), float(within.right()),
                                   float(within.top())) /
                   float(size);
  block_.on_layers = parts.map.on_layers();
  const Eigen::Vector4f middle =
      extent(shutter[shutter.size() / 2]).center().cast<float>().homogeneous();
  block_.pivot = block.light_projection.row(2).dot(middle);
  for (int k = 0; k < count_; ++k) {
    const Eigen::Vector2f offset = light_offset(block.light_projection, k);
    block_.moved_light[std::size_t(k)] = {offset.x(), offset.y(), 0, 0};
  }
}

void SweptShadows::fill() {
  const auto draw = [&](const FrameState& instant, auto triangles, auto into) {
    parts_.parts.pose(instant);
    std::vector<DrawItem> casters;
    for (std::size_t k = 0; const DrawItem& item : parts_.parts.items(instant))
      casters.emplace_back(item, triangles(k++));
    into(casters);
  };
  const auto casting = [&](int grade) {
    return [&, grade](std::size_t k) { return extents_.casting(k, grade); };
  };
  parts_.surfaces.use(block_);
  parts_.draw_solid();
  const int slowest = is_layered(1) ? exposures_of(1) : 1, last = int(grades_.size());
  for (int slow = 0; slow < slowest; ++slow) {
    parts_.map.restore(changing_);
    if (is_layered(1))
      draw(shown_at(shutter_, slow, slowest), casting(1),
           [&](const auto& casters) { parts_.map.draw(casters); });
    for (int layer = slow * count_ / slowest; layer < (slow + 1) * count_ / slowest; ++layer) {
      parts_.map.keep_layer(layer);
      const auto into = [&](const auto& casters) { parts_.map.draw_layer(layer, casters); };
      int grade = is_layered(1) ? 2 : 1;
      for (; grade <= last && is_layered(grade); ++grade)
        draw(shown_at(shutter_, layer * exposures_of(grade) / count_, exposures_of(grade)),
             casting(grade), into);
      if (grade <= last)
        draw(
            shown_at(shutter_, layer, count_),
            [&](std::size_t k) { return extents_.moving(k, grade); }, into);
    }
  }
}

FrameBlock SweptShadows::seen(int grade, int i) const {
  const int exposures = exposures_of(grade);
  FrameBlock seen = block_;
  seen.first_layer = i * count_ / exposures;
  seen.end_layer = (i + 1) * count_ / exposures;
  return seen;
}

}  // namespace taut::draw
