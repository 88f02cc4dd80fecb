#include "render/draw/brute_force.h"

#include <functional>

#include "render/draw/swept_shadows.h"

namespace taut::draw {
namespace {

std::vector<DrawItem> all_items(StageParts& parts, const FrameState& instant) {
  parts.parts.pose(instant);
  return parts.parts.items(instant);
}

void draw_items(StageParts& parts, std::span<const DrawItem> items, Shade shade) {
  parts.gl.DepthFunc(GL_LESS);
  for (const DrawItem& item : items) parts.surfaces.draw(item, shade);
}

}  // namespace

void draw_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                const FrameState& instant, const Layer& layer) {
  parts.parts.pose(instant);
  const std::vector<DrawItem> items = parts.parts.items(instant, layer);
  const bool solid = layer.opacity >= 1;
  parts.surfaces.use(parts.look(instant, viewport).block);
  parts.draw_solid();
  parts.map.clear();
  if (solid && layer.shadow) parts.map.draw(items);
  parts.aim(canvas, viewport);
  if (!solid) {
    parts.gl.Enable(GL_BLEND);
    parts.gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }
  for (const DrawItem& item : items) parts.surfaces.draw(item, Shade::shadowed, layer.opacity);
  if (solid) parts.draw_scenery(Shade::grounded);
}

void expose_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                  std::span<const FrameState> shutter, std::span<const Exposures> grades,
                  const MotionExtents& extents) {
  const FrameState& middle = shutter[shutter.size() / 2];
  const FrameBlock block = parts.look(middle, viewport).block;
  const int samples = canvas.samples(), count = grades.back().count;
  using Chosen = std::function<std::span<const std::uint32_t>(std::size_t)>;
  const auto chosen = [](std::vector<DrawItem> items, const Chosen& triangles) {
    for (std::size_t k = 0; DrawItem & item : items) item = {item, triangles(k++)};
    return items;
  };
  const auto casting = [&](int grade) {
    return [&extents, grade](std::size_t k) { return extents.casting(k, grade); };
  };
  const picture::Rect map{0, 0, parts.map.size(), parts.map.size()};
  parts.surfaces.use(block);
  parts.draw_solid();
  parts.map.clear();
  parts.map.draw(chosen(all_items(parts, middle), casting(0)));
  parts.map.save(map);
  SweptShadows shadows(parts, extents, shutter, grades, samples, block, map, map);
  shadows.fill();
  const auto show = [&](const std::vector<DrawItem>& items, int grade, Shade shade,
                        const FrameBlock& seen, bool swept) {
    parts.aim(canvas, viewport);
    parts.surfaces.use(seen);
    const auto triangles = [&](std::size_t k) {
      return swept ? extents.swept(k, grade) : extents.plain(k, grade);
    };
    draw_items(parts, chosen(items, triangles), shade);
  };
  const auto draw = [&](int i) {
    parts.draw_solid();
    parts.map.restore(map);
    show(all_items(parts, middle), 0, Shade::shadowed, block, false);
    show(all_items(parts, middle), 0, Shade::swept, shadows.seen(0, 0), true);
    parts.draw_scenery(Shade::grounded_swept);
    for (std::size_t grade = 1; grade <= grades.size(); ++grade) {
      const int times = grades[grade - 1].count, at = canvas.exposure_among(times, i, count);
      const auto lowest = int(casting_grade(grades, grade, samples));
      const Shade shade = shade_of(times, samples);
      const FrameBlock seen = exposed(block, middle, viewport, at);
      const bool layered = shadows.is_layered(int(grade));
      FrameBlock swept_seen = seen;
      if (layered) {
        swept_seen = shadows.seen(int(grade), at);
        swept_seen.view_projection = seen.view_projection;
      }
      parts.surfaces.use(block);
      parts.draw_solid();
      parts.map.restore(map);
      for (int slower = 1; slower < lowest; ++slower)
        parts.map.draw(chosen(all_items(parts, middle), casting(slower)));
      const std::vector<DrawItem> items = all_items(parts, shown_at(shutter, at, times));
      parts.map.draw(chosen(items, [&](std::size_t k) { return extents.moving(k, lowest); }));
      show(items, int(grade), shade, seen, false);
      show(items, int(grade), layered ? Shade::swept : shade, swept_seen, true);
    }
  };
  const gl::Exposed whole{{0, 0, canvas.width(), canvas.height()}, count, draw};
  canvas.expose({&whole, 1});
}

void expose_whole(StageParts& parts, gl::Canvas& canvas, const picture::Rect& viewport,
                  std::span<const FrameState> shutter, int count) {
  const FrameState& middle = shutter[shutter.size() / 2];
  const FrameBlock block = parts.look(middle, viewport).block;
  const int samples = canvas.samples();
  const auto draw = [&](int i) {
    const std::vector<DrawItem> items = all_items(parts, shown_at(shutter, i, count));
    parts.surfaces.use(block);
    parts.draw_solid();
    parts.map.clear();
    parts.map.draw(items);
    parts.aim(canvas, viewport);
    parts.surfaces.use(exposed(block, middle, viewport, i));
    draw_items(parts, items, shade_of(count, samples));
    parts.surfaces.use(block);
    parts.draw_scenery(Shade::grounded);
  };
  const gl::Exposed whole{{0, 0, canvas.width(), canvas.height()}, count, draw};
  canvas.expose({&whole, 1});
}

}  // namespace taut::draw
