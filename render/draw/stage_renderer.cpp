#include "render/draw/stage_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "render/draw/motion_extents.h"
#include "render/draw/shading/shadow_map.h"
#include "render/draw/stage_parts.h"
#include "sim/motion/hash.h"
#include "sim/motion/stop.h"

namespace taut::draw {
namespace {

// Shadows of what moves on what is slower: many instants of them in one drawing of the latter.

/// Slow things take fewer exposures than the shadows that sweep over them. So each of their
/// exposures looks up several maps, the layers: in each things stand where their own exposures show
/// them at one instant of the shutter.
class SweptShadows {
 public:
  /// `changing` is the part of the map in which something moves, `casters` that in which anything
  /// casts; the map's saved state has what stands. All must outlive this.
  SweptShadows(StageParts& parts, const MotionExtents& extents, std::span<const FrameState> shutter,
               std::span<const Exposures> grades, int samples, const FrameBlock& block,
               const picture::Rect& changing, const picture::Rect& casters);

  /// Draws the layers.
  void fill();
  /// Whether the exposures of that grade look up layers; others are often enough themselves.
  bool is_layered(int grade) const { return exposures_of(grade) < count_; }
  /// How exposure `i` of a grade looks them up: those of its share of the shutter.
  FrameBlock seen(int grade, int i) const;

 private:
  int exposures_of(int grade) const {
    return grade > 0 ? grades_[std::size_t(grade) - 1].count : 1;
  }

  StageParts& parts_;
  const MotionExtents& extents_;
  const std::span<const FrameState> shutter_;
  const std::span<const Exposures> grades_;
  FrameBlock block_;
  const picture::Rect changing_;
  int count_;  // of layers
};

constexpr int kMostRoom = 4;       // layers as large as the map
constexpr int kMarginTexels = 16;  // texels that a look-up may lie off a penumbra

picture::Rect widened(const picture::Rect& part, int by, int size) {
  return picture::intersection(
      {part.x - by, part.y - by, part.width + 2 * by, part.height + 2 * by}, {0, 0, size, size});
}

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

namespace {

/// B/s of CPU time, read and written together.
double copying_speed() {
  constexpr std::size_t kBytes = std::size_t{1} << 25;  // beyond any cache
  std::vector<char> from(kBytes, 1), to(kBytes);
  double best = std::numeric_limits<double>::infinity();
  for (char round = 0; round < 5; ++round) {
    from[0] = round;
    const double start = thread_seconds();
    std::memcpy(to.data(), from.data(), kBytes);
    if (to[0] == round) best = std::min(best, thread_seconds() - start);
  }
  return 2 * double(kBytes) / best;
}

}  // namespace

StageFloor::StageFloor(int width, int height, int samples)
    : pixels_(double(width) * height), samples_(samples), speed_(copying_speed()) {}

std::optional<double> StageFloor::of(std::string_view stage, const gl::Profile& unlit) const {
  constexpr double kColor = 4, kRgb = 3;  // B
  if (stage == "resolve and tone map") return pixels_ * (samples_ + 1) * kColor / speed_;
  if (stage == "read back" || stage == "captions") return pixels_ * 2 * kColor / speed_;
  if (stage == "PNG") return pixels_ * (kColor + kRgb) / speed_;
  if (stage != "scenery" && stage != "figures" && stage != "shadows" && stage != "exposures")
    return std::nullopt;
  const auto found = std::ranges::find(unlit.stages(), stage, &gl::Profile::Stage::name);
  if (found == unlit.stages().end()) return std::nullopt;
  return gl::median(*found).cpu;
}

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr float kShadowFilter = 5;  // texels: half the filter, and the offset along the normal

/// The unit cube of the shadow map to clip space.
Matrix4f map_to_clip() {
  Matrix4f m = Matrix4f::Identity();
  m.diagonal().head<3>().setConstant(2);
  m.topRightCorner<3, 1>().setConstant(-1);
  return m;
}

}  // namespace

struct StageRenderer::Impl : StageParts {
  using StageParts::StageParts;

  void start_cover(const Look& look) {
    cover.start(look.block.light_projection, kShadowFilter / float(shading.map_size),
                look.block.penumbra);
  }

  /// The part of one thing of the scenery that shadows can reach or feet can darken.
  struct ReachedPart {
    Triangles triangles;
    Eigen::AlignedBox3f box;  // around them
    picture::Rect pixels;     // where the shadows fall
  };
  using Reached = std::vector<ReachedPart>;  // [scenery]
  void find_reached(const Boxes& contacts, Reached& found) {
    found.resize(scenery.size());
    for (std::size_t i = 0; i < scenery.size(); ++i)
      found[i].box =
          cover.find(scenery[i].triangles(), scenery[i].positions(), contacts, found[i].triangles);
  }

  /// Finds the pixels where shadows of those boxes fall, and returns the rectangle around all.
  picture::Rect find_pixels(const Boxes& casters, const Boxes& contacts, const FrameBlock& block,
                            const picture::Rect& viewport, Reached& found) const {
    const Vector3f direction = stage.light.direction.cast<float>();
    picture::Rect all;
    for (ReachedPart& part : found) {
      HullPoints hull;
      for (const auto& box : casters) {
        if (box.isEmpty() || part.box.isEmpty()) continue;
        // As much wider as the penumbra can be, and the filter.
        const float more = kSun * box.merged(part.box).diagonal().norm() + block.eye.w();
        const Vector3f margin = Vector3f::Constant(2 * more);
        add_shadow({box.min() - margin, box.max() + margin}, direction, part.box, hull);
      }
      for (const auto& box : contacts) add_box(box.intersection(part.box), hull);
      part.pixels = pixels(hull, block.view_projection, viewport);
      all = picture::hull(all, part.pixels);
    }
    return all;
  }

  /// The scenery once more, where it still is in front.
  void draw_reached(const Reached& found, Shade shade) {
    gl.DepthFunc(GL_LEQUAL);
    gl.Enable(GL_SCISSOR_TEST);
    for (std::size_t i = 0; i < scenery.size(); ++i) {
      const picture::Rect& part = found[i].pixels;
      if (part.empty()) continue;
      gl.Scissor(part.x, part.y, part.width, part.height);
      surfaces.draw({{scenery[i], Matrix4f::Identity()}, found[i].triangles}, shade);
    }
    gl.Disable(GL_SCISSOR_TEST);
  }

  /// Draws things, and the shadows of the casters.
  void paint(gl::Canvas& canvas, const picture::Rect& viewport, const Look& look,
             std::span<const DrawItem> things, std::span<const DrawItem> casters, float opacity) {
    const bool solid = opacity >= 1;
    surfaces.use(look.block);
    draw_solid();
    map.clear();
    if (solid) map.draw(casters);
    lap("shadow map");

    aim(canvas, viewport);
    if (!solid) {
      gl.Enable(GL_BLEND);
      gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    }
    HullPoints hull;
    for (const DrawItem& item : things) {
      surfaces.draw(item, Shade::shadowed, opacity);
      add_box(item.box(), hull);
    }
    canvas.touch(pixels(hull, look.block.view_projection, viewport));
    lap("figures");
    if (!solid) return;

    start_cover(look);
    Boxes boxes;
    for (const DrawItem& item : casters) {
      const Places places = places_of(item);
      cover.add(item.triangles, {&places, 1});
      boxes.push_back(item.box());
    }
    find_reached(look.contacts, still_reached);
    find_pixels(boxes, look.contacts, look.block, viewport, still_reached);
    draw_reached(still_reached, Shade::grounded);
    for (const ReachedPart& part : still_reached) canvas.touch(part.pixels);
    lap("shadows");
  }

  /// Draws what stands still, and the scenery, in the shadows that sweep over them.
  void paint_swept(gl::Canvas& canvas, const picture::Rect& viewport, SweptShadows& shadows,
                   const FrameState& middle) {
    shadows.fill();
    lap("layers");
    parts.pose(middle);
    aim(canvas, viewport);
    surfaces.use(shadows.seen(0, 0));
    draw_solid();
    for (std::size_t k = 0; const DrawItem& item : parts.items(middle))
      surfaces.draw({item, extents.swept(k++, 0)}, Shade::swept);
    draw_reached(moving_reached, Shade::grounded_swept);
    for (const ReachedPart& part : moving_reached) canvas.touch(part.pixels);
    lap("swept shadows");
  }

  /// Has what moves with the grade below stand in the shadow map, too.
  void settle(const FrameState& middle, const picture::Rect& map_part, int grade) {
    parts.pose(middle);
    std::vector<DrawItem> slower;
    for (std::size_t k = 0; const DrawItem& item : parts.items(middle))
      slower.emplace_back(item, extents.casting(k++, grade - 1));
    draw_solid();
    map.restore(map_part);
    map.draw(slower);
    map.save(map_part);
  }

  void lap(const char* name) const {
    if (!profile) return;
    gl.Finish();
    profile->lap(name);
  }

  /// Grades what moves while the shutter is open, and tells the exposures of each grade above 0;
  /// none where nothing moves. The cover then holds what moves.
  std::vector<Exposures> find_moving(std::span<const FrameState> shutter, const gl::Canvas& canvas,
                                     const Look& look, const picture::Rect& viewport);

  /// A backdrop takes as much memory as the canvas. Beside a million triangles that move, the
  /// scenery is a tenth of a frame's work.
  bool keeps_backdrops() const { return parts.triangles() < 1'000'000; }

  gl::Profile* profile = nullptr;
  ShadowCover cover;
  MotionExtents extents;
  Reached still_reached, moving_reached;  // by the shadows of what stands, and of what moves
};

StageRenderer::StageRenderer(const gl::Context& context, const scenes::Stage& stage,
                             const World& world, const Shading& shading)
    : impl_(std::make_unique<Impl>(context, stage, world, shading)) {}

StageRenderer::~StageRenderer() = default;

void StageRenderer::set_profile(gl::Profile* profile) {
  impl_->profile = profile;
}

void StageRenderer::set_background(const Vec3& color) {
  impl_->background = color;
}

void StageRenderer::set_shift(const Eigen::Vector2f& pixels) {
  impl_->shift = pixels;
}

void StageRenderer::begin(gl::Canvas& canvas, std::span<const View> views) {
  Impl& d = *impl_;
  if (d.shading.savings != Savings::all) {
    canvas.restore(0);
    return draw_backdrop(d, canvas, views);
  }
  Hash name;
  for (int k = 0; k < 3; ++k) name.number(d.background[k]);
  name.number(d.shift.x()).number(d.shift.y());
  for (const auto& [viewport, camera] : views) {
    for (const int pixels : {viewport.x, viewport.y, viewport.width, viewport.height})
      name.number(pixels);
    for (int k = 0; k < 3; ++k) name.number(camera.position[k]).number(camera.target[k]);
    name.number(camera.field_of_view).number(camera.relative_aperture).number(camera.focus);
  }
  if (canvas.restore(name.value())) return d.lap("backdrop");

  draw_backdrop(d, canvas, views);
  if (d.keeps_backdrops()) canvas.keep(name.value());
  d.lap("scenery");
}

void StageRenderer::draw(gl::Canvas& canvas, const picture::Rect& viewport,
                         const FrameState& instant, const Layer& layer) {
  Impl& d = *impl_;
  if (d.shading.savings != Savings::all) return draw_whole(d, canvas, viewport, instant, layer);
  d.parts.pose(instant);
  d.lap("skin");
  const std::vector<DrawItem> items = d.parts.items(instant, layer);
  d.paint(canvas, viewport, d.look(instant, viewport), items,
          layer.shadow ? std::span<const DrawItem>(items) : std::span<const DrawItem>(),
          layer.opacity);
}

std::vector<Exposures> StageRenderer::Impl::find_moving(std::span<const FrameState> shutter,
                                                        const gl::Canvas& canvas, const Look& look,
                                                        const picture::Rect& viewport) {
  const std::array shown{&shutter.front(), &shutter[shutter.size() / 2], &shutter.back()};
  extents.start(parts.items(*shown[1]),
                {shown[0]->state.time, shown[1]->state.time, shown[2]->state.time},
                [&parts = parts, shown](std::size_t time, std::size_t item, Places& places) {
                  parts.find_places(*shown[time], item, places);
                });
  const MotionExtents::Travel travel =
      extents.find_moving(look.block.view_projection, viewport, shading.still);
  if (travel.way <= shading.still) return {};
  double longest = 0;  // s from one state to the next
  for (std::size_t i = 1; i < shutter.size(); ++i)
    longest = std::max(longest, shutter[i].state.time - shutter[i - 1].state.time);
  const double open = longest * double(shutter.size());  // s
  const std::vector<Exposures> grades =
      exposures(travel.speed * open, canvas.samples(), int(shutter.size()), stage.exposures_apart);
  if (grades.empty()) return {};
  std::vector<double> speeds;
  for (std::size_t i = 0; i + 1 < grades.size(); ++i) speeds.push_back(grades[i].way / open);
  extents.grade(speeds);
  start_cover(look);
  const std::size_t shadows = shadow_grade(grades, canvas.samples());
  for (std::size_t grade = grades.size(); grade > 0; --grade)
    extents.sweep(cover, int(grade), int(std::min(grade, shadows)));
  extents.divide();
  return grades;
}

int StageRenderer::expose(gl::Canvas& canvas, const picture::Rect& viewport,
                          std::span<const FrameState> shutter) {
  Impl& d = *impl_;
  const FrameState& middle = shutter[shutter.size() / 2];
  const Look look = d.look(middle, viewport);
  const std::vector<Exposures> grades = d.find_moving(shutter, canvas, look, viewport);
  d.lap("sweep");
  if (grades.empty()) {
    draw(canvas, viewport, middle);
    return 1;
  }
  const int most = grades.back().count;
  if (d.shading.savings == Savings::exposures) {
    expose_whole(d, canvas, viewport, shutter, grades, d.extents);
    return most;
  }
  if (d.shading.savings == Savings::none) {
    expose_whole(d, canvas, viewport, shutter, most);
    return most;
  }

  // The changing part of the scenery and of the shadow map: the cover holds all that moves.
  d.find_reached({}, d.moving_reached);
  d.parts.pose(middle);
  const std::vector<DrawItem> items = d.parts.items(middle);
  std::vector<DrawItem> still, still_casters;
  Boxes casting;
  HullPoints in_map;
  for (std::size_t i = 0; i < items.size(); ++i) {
    still.emplace_back(items[i], d.extents.plain(i, 0));
    still_casters.emplace_back(items[i], d.extents.casting(i, 0));
    casting.push_back(d.extents.moving_box(i));
    add_box(casting.back(), in_map);
  }
  const auto on_map = [&](const HullPoints& hull) {
    return pixels(hull, map_to_clip() * look.block.light_projection,
                  {0, 0, d.map.size(), d.map.size()});
  };
  const picture::Rect map_part = on_map(in_map);
  for (const DrawItem& item : items) add_box(item.box(), in_map);
  const picture::Rect casters_part = on_map(in_map);
  d.find_pixels(casting, {}, look.block, viewport, d.moving_reached);
  d.lap("sweep");
  d.paint(canvas, viewport, look, still, still_casters, 1);
  d.map.save(map_part);
  SweptShadows shadows(d, d.extents, shutter, grades, canvas.samples(), look.block, map_part,
                       casters_part);
  d.paint_swept(canvas, viewport, shadows, middle);

  std::vector<gl::Exposed> together;  // those that share what stands in the shadow map
  for (std::size_t grade = 1; grade <= grades.size(); ++grade) {
    const auto lowest = int(casting_grade(grades, grade, canvas.samples()));
    if (lowest > 1 && lowest == int(grade)) {
      canvas.expose(together);
      together.clear();
      d.surfaces.use(look.block);
      d.settle(middle, map_part, lowest);
    }
    HullPoints things;
    for (std::size_t i = 0; i < items.size(); ++i)
      add_box(d.extents.casting_box(i, int(grade)), things);
    const picture::Rect part = pixels(things, look.block.view_projection, viewport);
    if (part.empty()) continue;
    const int count = grades[grade - 1].count;
    bool swept = false;
    for (std::size_t i = 0; i < items.size(); ++i) swept |= !d.extents.swept(i, int(grade)).empty();
    const auto draw = [&, grade, lowest, swept, part, count](int i) {
      check_stop();
      const bool layered = swept && shadows.is_layered(int(grade));
      FrameBlock seen = exposed(look.block, middle, viewport, i), swept_seen = seen;
      if (layered) {
        swept_seen = shadows.seen(int(grade), i);
        swept_seen.view_projection = seen.view_projection;
      }
      const FrameState& instant = shown_at(shutter, i, count);
      d.parts.pose(instant);
      std::vector<DrawItem> plain, in_shadows, casters;
      for (std::size_t k = 0; const DrawItem& item : d.parts.items(instant)) {
        plain.emplace_back(item, d.extents.plain(k, int(grade)));
        in_shadows.emplace_back(item, d.extents.swept(k, int(grade)));
        casters.emplace_back(item, d.extents.moving(k, lowest));
        ++k;
      }
      d.surfaces.use(look.block);
      d.draw_solid();
      d.map.restore(map_part);
      d.map.draw(casters);

      d.aim(canvas, viewport);
      d.gl.Enable(GL_SCISSOR_TEST);
      d.gl.Scissor(part.x, part.y, part.width, part.height);
      const Shade shade = shade_of(count, canvas.samples());
      d.surfaces.use(seen);
      for (const DrawItem& item : plain) d.surfaces.draw(item, shade);
      d.surfaces.use(swept_seen);
      for (const DrawItem& item : in_shadows) d.surfaces.draw(item, layered ? Shade::swept : shade);
      d.surfaces.use(look.block);
    };
    together.push_back({part, count, draw});
  }
  canvas.expose(together);
  d.lap("exposures");
  return most;
}

}  // namespace taut::draw
