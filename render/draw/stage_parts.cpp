#include "render/draw/stage_parts.h"

#include <algorithm>

#include "render/draw/jitter.h"
#include "render/draw/shading/lighting.h"

namespace taut::draw {
namespace {

Eigen::Vector4f with_w(const Vec3& v, double w) {
  return {float(v.x()), float(v.y()), float(v.z()), float(w)};
}

std::vector<Drawable> scenery_of(const gl::Gl& gl, const scenes::Stage& stage) {
  std::vector<Drawable> scenery;
  for (const auto& model : stage.scenery)
    for (Drawable& part : drawables(gl, *model)) scenery.push_back(std::move(part));
  return scenery;
}

std::vector<const scenes::Mesh*> meshes_of(const scenes::Stage& stage) {
  std::vector<const scenes::Mesh*> meshes;
  for (const auto& model : stage.scenery)
    for (const scenes::Mesh& mesh : model->meshes) meshes.push_back(&mesh);
  return meshes;
}

Vec3 looked_at(const scenes::Stage& stage) {
  return stage.camera.empty() ? Vec3(Vec3::Zero()) : scenes::camera_at(stage.camera, 0).target;
}

/// As many as there is room for, of what is nearest to the floor first.
CapsuleCounts counts_of(const scenes::Stage& stage, const Shading& shading) {
  CapsuleCounts counts;
  if (!shading.contact) return counts;
  const auto add = [](std::size_t before, std::size_t more) {
    return int(std::min(before + more, kCapsules));
  };
  std::size_t soles = 0, lower = 0, others = 0;
  for (const auto& model : stage.characters) {
    const std::vector<Pose> bones(model->bones.size());
    soles += feet(*model, bones).size();
    lower += shins(*model, bones).size();
    others += arms(*model).size();
  }
  for (const auto& model : stage.body_models) others += model && rod(*model);
  counts.feet = add(0, soles);
  counts.legs = add(soles, lower);
  counts.all = add(soles + lower, others);
  return counts;
}

Surroundings surroundings_of(const scenes::Stage& stage, const RoomLight& room) {
  if (room.encloses()) return room.surroundings();
  return {ambient_harmonics(stage.light)};
}

}  // namespace

StageParts::StageParts(const gl::Context& context, const scenes::Stage& s, const World& world,
                       const Shading& options)
    : gl(context.gl()),
      stage(s),
      shading(options),
      background(s.background),
      scenery(scenery_of(gl, s)),
      scenery_shadow(gl, s.light, scenery),
      room(gl, s.light, scenery, meshes_of(s), scenery_shadow, looked_at(s)),
      capsules(counts_of(s, options)),
      surfaces(gl, s.light, surroundings_of(s, room), scenery_shadow, options.map_size,
               options.lit ? Output::display : Output::flat, capsules),
      map(gl, options.map_size),
      parts(gl, s, world) {
  for (const auto& model : stage.characters) arms_.push_back(arms(*model));
  for (const auto& model : stage.body_models) rods_.push_back(model ? rod(*model) : std::nullopt);
}

Look StageParts::look(const FrameState& instant, const picture::Rect& viewport) const {
  Look look{{instant.camera, viewport}, {}};
  const LightMap light = light_map(stage.light.direction, extent(instant), shading.map_size);
  FrameBlock& block = look.block;
  block.light_projection = light.projection;
  block.eye.w() = float(1.5 * light.texel);
  block.penumbra = penumbra(light.projection);
  block.texel_depth = float(light.texel) * light.projection.row(2).head<3>().norm();
  if (!shading.contact) return look;
  std::size_t next = 0;
  const auto add = [&](const ContactCapsule& capsule) {
    if (next == kCapsules) return false;
    const std::size_t i = next++;
    const Vec3 axis = capsule.to - capsule.from;
    block.capsule_from[i] = with_w(capsule.from, capsule.radius);
    block.capsule_to[i] = with_w(capsule.to, 1 / std::max(axis.squaredNorm(), 1e-6));
    return true;
  };
  for (std::size_t c = 0; c < std::min(instant.bones.size(), stage.characters.size()); ++c)
    for (const ContactCapsule& capsule : feet(*stage.characters[c], instant.bones[c]))
      if (add(capsule)) look.contacts.push_back(capsule.bounds());
  next = std::size_t(capsules.feet);  // where characters without bones would have theirs
  for (std::size_t c = 0; c < std::min(instant.bones.size(), stage.characters.size()); ++c)
    for (const ContactCapsule& shin : shins(*stage.characters[c], instant.bones[c])) add(shin);
  next = std::size_t(capsules.legs);
  for (std::size_t c = 0; c < std::min(instant.bones.size(), arms_.size()); ++c)
    for (const scenes::Capsule& arm :
         scenes::place_capsules(arms_[c], *stage.characters[c], instant.bones[c]))
      add({arm.a, arm.b, arm.radius});
  for (std::size_t i = 0; i < std::min(rods_.size(), instant.state.bodies.size()); ++i) {
    if (!rods_[i]) continue;
    const Pose& at = instant.state.bodies[i];
    add({at.position + at.rotation * rods_[i]->from, at.position + at.rotation * rods_[i]->to,
         rods_[i]->radius});
  }
  return look;
}

void StageParts::draw_solid() const {
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_LESS);
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(GL_BACK);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_SCISSOR_TEST);
}

void StageParts::aim(const gl::Canvas& canvas, const picture::Rect& viewport) const {
  canvas.bind();
  gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
  map.bind();
  if (canvas.backdrop_light()) gl.BindTextureUnit(3, canvas.backdrop_light());
}

void StageParts::clear(const gl::Canvas& canvas) const {
  canvas.bind();
  // As it is asked for, without the curve that lit surfaces go through.
  const Vec3 c = background.cwiseMin(1).cwiseSqrt();
  gl.ClearColor(float(c.x()), float(c.y()), float(c.z()), 1);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void StageParts::draw_scenery(Shade shade) {
  gl.DepthFunc(GL_LEQUAL);  // where faces coincide, the last is in front: with its shadows, too
  for (Drawable& part : scenery) surfaces.draw({part, Eigen::Matrix4f::Identity()}, shade);
}

void draw_backdrop(StageParts& parts, gl::Canvas& canvas, std::span<const View> views) {
  const auto draw = [&](int i) {
    parts.draw_solid();
    parts.clear(canvas);
    for (const auto& [viewport, camera] : views) {
      FrameBlock block(camera, viewport);
      block.view_projection = moved_backdrop(block.view_projection, viewport, i);
      parts.surfaces.use(block);
      parts.gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
      parts.draw_scenery(Shade::lit);
    }
  };
  if (parts.scenery.empty()) return draw(0);
  std::vector<gl::DefocusedView> unfocused;
  for (const auto& [viewport, camera] : views)
    if (camera.relative_aperture > 0 && parts.shading.lit)
      unfocused.push_back({viewport, confusion(camera, viewport.height)});
  // What moves past has no edges that are looked at for long: those are smoothed as of all that
  // moves.
  const bool moves = std::ranges::any_of(views, [](const View& v) { return v.camera.moves; });
  canvas.draw_backdrop(moves ? 1 : backdrop_pictures(canvas.samples()), draw, unfocused);
}

FrameBlock exposed(const FrameBlock& block, const FrameState& middle, const picture::Rect& viewport,
                   int i) {
  FrameBlock moved = block;
  moved.light_projection = moved_light(block.light_projection, extent(middle).center(), i);
  moved.view_projection = moved_picture(block.view_projection, viewport, i);
  return moved;
}

const FrameState& shown_at(std::span<const FrameState> shutter, int i, int count) {
  const int stride = int(shutter.size()) / count;
  return shutter[std::size_t(stride / 2 + i * stride)];
}

Shade shade_of(int count, int samples) {
  return count < samples ? Shade::shadowed : Shade::averaged;
}

}  // namespace taut::draw
