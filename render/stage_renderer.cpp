#include "render/stage_renderer.h"

#include <algorithm>

#include "render/contact.h"
#include "render/jitter.h"
#include "render/lighting.h"
#include "render/moving_parts.h"
#include "render/reach.h"
#include "render/shadow_cover.h"
#include "render/shadow_map.h"
#include "render/surfaces.h"
#include "render/sweep.h"
#include "sim/hash.h"

namespace taut {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Boxes = std::vector<Eigen::AlignedBox3f>;

constexpr float kShadowFilter = 5;  // texels: half the filter, and the offset along the normal

Eigen::Vector4f with_w(const Vec3& v, double w) {
  return {float(v.x()), float(v.y()), float(v.z()), float(w)};
}

/// The unit cube of the shadow map to clip space.
Matrix4f map_to_clip() {
  Matrix4f m = Matrix4f::Identity();
  m.diagonal().head<3>().setConstant(2);
  m.topRightCorner<3, 1>().setConstant(-1);
  return m;
}

/// Removes some triangles from others; both are in the same order.
void remove(const Triangles& some, Triangles& from) {
  auto next = some.begin();
  auto kept = from.begin();
  for (auto corner = from.begin(); corner != from.end(); corner += 3) {
    if (next != some.end() && std::equal(corner, corner + 3, next))
      next += 3;
    else
      kept = std::copy(corner, corner + 3, kept);
  }
  from.erase(kept, from.end());
}

/// What exposure `i` of so many shows: states evenly apart.
const Instant& shown_at(std::span<const Instant> shutter, int i, int count) {
  const int stride = int(shutter.size()) / count;
  return shutter[std::size_t(stride / 2 + i * stride)];
}

}  // namespace

struct StageRenderer::Impl {
  Impl(const Context& context, const Stage& s, const World& world, const Shading& options)
      : gl(context.gl()),
        stage(s),
        shading(options),
        background(s.background),
        surfaces(gl, s.light, options.map_size, options.lit),
        map(gl, options.map_size),
        parts(gl, s, world) {
    for (const auto& model : stage.scenery)
      for (Drawable& part : drawables(gl, *model)) scenery.push_back(std::move(part));
  }

  /// How a picture of that instant is seen and lit, and what feet can darken.
  struct Look {
    FrameBlock block;
    Boxes contacts;
  };
  Look look(const Instant& instant, const Rect& viewport) const {
    Look look{{instant.camera, viewport}, {}};
    const LightMap light = light_map(stage.light.direction, extent(instant), shading.map_size);
    FrameBlock& block = look.block;
    block.light_projection = light.projection;
    block.eye.w() = float(1.5 * light.texel);
    if (!shading.contact) return look;
    for (std::size_t c = 0; c < std::min(instant.bones.size(), stage.characters.size()); ++c)
      for (const ContactCapsule& capsule : feet(*stage.characters[c], instant.bones[c])) {
        const std::size_t i = look.contacts.size();
        if (i == kCapsules) break;
        const Vec3 axis = capsule.to - capsule.from;
        block.capsule_from[i] = with_w(capsule.from, capsule.radius);
        block.capsule_to[i] = with_w(capsule.to, 1 / std::max(axis.squaredNorm(), 1e-6));
        look.contacts.push_back(capsule.reach());
      }
    block.capsules[0] = int(look.contacts.size());
    return look;
  }

  void draw_solid() const {
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthMask(GL_TRUE);
    gl.DepthFunc(GL_LESS);
    gl.Enable(GL_CULL_FACE);
    gl.CullFace(GL_BACK);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_SCISSOR_TEST);
  }

  void aim(const Canvas& canvas, const Rect& viewport) const {
    canvas.bind();
    gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
    gl.BindTextureUnit(0, map.texture());
  }

  void start_cover(const Look& look) {
    cover.start(look.block.light_projection, kShadowFilter / float(shading.map_size));
  }

  /// What shadows can reach or feet can darken of one thing of the scenery.
  struct ReachedPart {
    Triangles triangles;
    Eigen::AlignedBox3f box;  // around them
    Rect pixels;              // where the shadows fall
  };
  using Reached = std::vector<ReachedPart>;  // [scenery]
  void find_reached(const Boxes& contacts, Reached& found) {
    found.resize(scenery.size());
    for (std::size_t i = 0; i < scenery.size(); ++i)
      found[i].box =
          cover.find(scenery[i].triangles(), scenery[i].positions(), contacts, found[i].triangles);
  }

  /// Finds the pixels where shadows of those boxes fall, and returns the rectangle around all.
  Rect find_pixels(const Boxes& casters, const Boxes& contacts, const FrameBlock& block,
                   const Rect& viewport, Reached& found) const {
    const Vector3f direction = stage.light.direction.cast<float>();
    Rect all;
    for (ReachedPart& part : found) {
      HullPoints reach;
      for (const auto& box : casters) add_shadow(box, direction, part.box, reach);
      for (const auto& box : contacts) add_box(box.intersection(part.box), reach);
      part.pixels = pixels(reach, block.view_projection, viewport);
      all = hull(all, part.pixels);
    }
    return all;
  }

  /// The scenery once more, where it still is in front.
  void draw_reached(const Reached& found) {
    gl.DepthFunc(GL_LEQUAL);
    gl.Enable(GL_SCISSOR_TEST);
    for (std::size_t i = 0; i < scenery.size(); ++i) {
      const Rect& part = found[i].pixels;
      if (part.empty()) continue;
      gl.Scissor(part.x, part.y, part.width, part.height);
      surfaces.draw({{scenery[i], Matrix4f::Identity()}, found[i].triangles}, Shade::grounded);
    }
    gl.Disable(GL_SCISSOR_TEST);
  }

  /// Draws things, and the shadows of the casters.
  void paint(Canvas& canvas, const Rect& viewport, const Look& look, std::span<const Item> things,
             std::span<const Item> casters, float opacity) {
    const bool solid = opacity >= 1;
    surfaces.use(look.block);
    draw_solid();
    // Scenery casts no shadow: the key light is a stage's light, and walls would shut it out.
    map.clear();
    if (solid) map.draw(casters);
    lap("shadow map");

    aim(canvas, viewport);
    if (!solid) {
      gl.Enable(GL_BLEND);
      gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    }
    HullPoints reach;
    for (const Item& item : things) {
      surfaces.draw(item, Shade::shadowed, opacity);
      add_box(item.box(), reach);
    }
    canvas.touch(pixels(reach, look.block.view_projection, viewport));
    lap("figures");
    if (!solid) return;

    start_cover(look);
    Boxes boxes;
    for (const Item& item : casters) {
      const Places places = places_of(item);
      cover.add(item.triangles, {&places, 1});
      boxes.push_back(item.box());
    }
    find_reached(look.contacts, reached[0]);
    find_pixels(boxes, look.contacts, look.block, viewport, reached[0]);
    draw_reached(reached[0]);
    for (const ReachedPart& part : reached[0]) canvas.touch(part.pixels);
    lap("shadows");
  }

  void lap(const char* name) const {
    if (!profile) return;
    gl.Finish();
    profile->lap(name);
  }

  const Gl& gl;
  const Stage& stage;
  const Shading shading;
  Vec3 background;
  Profile* profile = nullptr;
  Surfaces surfaces;
  ShadowMap map;
  MovingParts parts;
  std::vector<Drawable> scenery;
  ShadowCover cover;
  Sweep sweep;
  std::vector<Reached> reached{1};  // [grade], by the shadows of what moves so, or faster
};

StageRenderer::StageRenderer(const Context& context, const Stage& stage, const World& world,
                             const Shading& shading)
    : impl_(std::make_unique<Impl>(context, stage, world, shading)) {}

StageRenderer::~StageRenderer() = default;

void StageRenderer::set_profile(Profile* profile) {
  impl_->profile = profile;
}

void StageRenderer::set_background(const Vec3& color) {
  impl_->background = color;
}

void StageRenderer::begin(Canvas& canvas, std::span<const View> views) {
  Impl& d = *impl_;
  const Gl& gl = d.gl;
  Hash name;
  for (int k = 0; k < 3; ++k) name.number(d.background[k]);
  for (const auto& [viewport, camera] : views) {
    for (const int pixels : {viewport.x, viewport.y, viewport.width, viewport.height})
      name.number(pixels);
    for (int k = 0; k < 3; ++k) name.number(camera.position[k]).number(camera.target[k]);
    name.number(camera.field_of_view);
  }
  if (canvas.restore(name.value())) return d.lap("backdrop");

  d.draw_solid();
  canvas.bind();
  // As it is asked for, without the curve that lit surfaces go through.
  const Vec3 c = d.background.cwiseMin(1).cwiseSqrt();
  gl.ClearColor(float(c.x()), float(c.y()), float(c.z()), 1);
  gl.DepthFunc(GL_LEQUAL);  // where faces coincide, the last is in front: with its shadows, too
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  for (const auto& [viewport, camera] : views) {
    d.surfaces.use({camera, viewport});
    gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
    for (Drawable& part : d.scenery) d.surfaces.draw({part, Matrix4f::Identity()}, Shade::lit);
  }
  canvas.keep(name.value());
  d.lap("scenery");
}

void StageRenderer::draw(Canvas& canvas, const Rect& viewport, const Instant& instant,
                         const Layer& layer) {
  Impl& d = *impl_;
  d.parts.pose(instant);
  d.lap("skin");
  const std::vector<Item> items = d.parts.items(instant, layer);
  d.paint(canvas, viewport, d.look(instant, viewport), items, items, layer.opacity);
}

int StageRenderer::expose(Canvas& canvas, const Rect& viewport, std::span<const Instant> shutter) {
  Impl& d = *impl_;
  const Instant& middle = shutter[shutter.size() / 2];
  const Impl::Look look = d.look(middle, viewport);
  d.sweep.clear();
  for (const Instant* instant : {&shutter.front(), &middle, &shutter.back()}) {
    d.parts.pose(*instant);
    d.sweep.add(d.parts.items(*instant), instant->state.time);
  }
  const Sweep::Travel travel = d.sweep.find_moving(look.block.view_projection, viewport);
  double longest = 0;  // s from one state to the next
  for (std::size_t i = 1; i < shutter.size(); ++i)
    longest = std::max(longest, shutter[i].state.time - shutter[i - 1].state.time);
  const double open = longest * double(shutter.size());  // s
  const std::vector<Exposures> grades = exposures(travel.speed * open, canvas.samples(),
                                                  int(shutter.size()), d.stage.exposures_apart);
  d.lap("sweep");
  if (grades.empty() || travel.way <= Sweep::kStill) {
    draw(canvas, viewport, middle);
    return 1;
  }

  // What changes with each grade, and where on the picture and in the shadow map.
  std::vector<double> speeds;
  for (std::size_t i = 0; i + 1 < grades.size(); ++i) speeds.push_back(grades[i].way / open);
  d.sweep.grade(speeds);
  d.start_cover(look);
  d.reached.resize(std::max(d.reached.size(), grades.size() + 1));
  for (std::size_t grade = grades.size(); grade > 0; --grade) {
    d.sweep.shade(d.cover, int(grade));
    d.find_reached({}, d.reached[grade]);
    // What faster things shade, too, is drawn with these.
    for (std::size_t above = grade + 1; above <= grades.size(); ++above)
      for (std::size_t i = 0; i < d.scenery.size(); ++i)
        remove(d.reached[above][i].triangles, d.reached[grade][i].triangles);
  }
  d.sweep.divide();
  d.parts.pose(middle);
  const std::vector<Item> items = d.parts.items(middle);
  std::vector<Item> still, still_casters;
  HullPoints in_map;
  for (std::size_t i = 0; i < items.size(); ++i) {
    still.emplace_back(items[i], d.sweep.shown(i, 0));
    still_casters.emplace_back(items[i], d.sweep.standing(i));
    add_box(d.sweep.moving_box(i, 1), in_map);
  }
  const Rect map_part = pixels(in_map, map_to_clip() * look.block.light_projection,
                               {0, 0, d.map.size(), d.map.size()});
  d.lap("sweep");
  d.paint(canvas, viewport, look, still, still_casters, 1);
  d.map.save(map_part);

  for (std::size_t grade = 1; grade <= grades.size(); ++grade) {
    Impl::Reached& reached = d.reached[grade];
    Boxes casting;
    HullPoints things;
    for (std::size_t i = 0; i < items.size(); ++i) {
      casting.push_back(d.sweep.moving_box(i, int(grade)));
      add_box(d.sweep.box(i, d.sweep.shown(i, int(grade))), things);
    }
    const Rect shadow = d.find_pixels(casting, {}, look.block, viewport, reached);
    const Rect part = hull(pixels(things, look.block.view_projection, viewport), shadow);
    if (part.empty()) continue;
    const int count = grades[grade - 1].count;
    canvas.expose(part, count, [&](int i) {
      const Instant& instant = shown_at(shutter, i, count);
      d.parts.pose(instant);
      std::vector<Item> shown, casters;
      for (std::size_t k = 0; const Item& item : d.parts.items(instant)) {
        shown.emplace_back(item, d.sweep.shown(k, int(grade)));
        casters.emplace_back(item, d.sweep.moving(k));
        ++k;
      }
      d.surfaces.use(look.block);
      d.draw_solid();
      d.map.restore(map_part);
      d.map.draw(casters);

      FrameBlock block = look.block;
      block.light_projection = moved_light(block.light_projection, extent(middle).center(), i);
      FrameBlock moved = block;
      if (count > canvas.samples())
        moved.view_projection = moved_picture(block.view_projection, viewport, i);
      d.aim(canvas, viewport);
      d.surfaces.use(moved);
      d.gl.Enable(GL_SCISSOR_TEST);
      d.gl.Scissor(part.x, part.y, part.width, part.height);
      const Shade shade = count < canvas.samples() ? Shade::shadowed : Shade::averaged;
      for (const Item& item : shown) d.surfaces.draw(item, shade);
      d.surfaces.use(block);
      d.draw_reached(reached);
    });
  }
  d.lap("exposures");
  return grades.back().count;
}

}  // namespace taut
