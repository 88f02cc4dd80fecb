#include "render/draw/stage_parts.h"

#include <algorithm>

#include "render/draw/motion_extents.h"
#include "render/draw/shading/lighting.h"
#include "render/mesh/skinning.h"

namespace taut::draw {
namespace {

using Eigen::Matrix4f;

Matrix4f matrix(const Pose& pose) {
  Matrix4f m = Matrix4f::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix().cast<float>();
  m.topRightCorner<3, 1>() = pose.position.cast<float>();
  return m;
}

}  // namespace

std::vector<Drawable> drawables(const gl::Gl& gl, const scenes::Model& model) {
  std::vector<std::shared_ptr<const gl::GlObject>> textures;
  for (const scenes::Texture& texture : model.textures)
    textures.push_back(std::make_shared<const gl::GlObject>(make_picture_texture(gl, texture)));
  std::vector<Drawable> result;
  for (const scenes::Mesh& mesh : model.meshes) {
    const scenes::Material& material = model.materials[mesh.material];
    result.emplace_back(gl, mesh, material,
                        material.texture < 0 ? nullptr : textures[std::size_t(material.texture)]);
  }
  return result;
}

MovingParts::MovingParts(const gl::Gl& gl, const scenes::Stage& stage, const World& world)
    : stage_(stage) {
  for (const auto& model : stage.body_models)
    bodies_.push_back(model ? drawables(gl, *model) : std::vector<Drawable>());
  for (const auto& model : stage.characters) characters_.push_back(drawables(gl, *model));
  const auto same = [](const mesh::RestVertex& a, const mesh::RestVertex& b) {
    return a.rest == b.rest && a.color == b.color;
  };
  std::shared_ptr<const RestShape> shape;  // of the last connector: those of a row are alike
  for (std::size_t i = 0; i < world.connectors.size(); ++i) {
    const scenes::ConnectorLook look =
        i < stage.connector_looks.size() ? stage.connector_looks[i] : scenes::ConnectorLook();
    connector_meshes_.push_back(
        mesh::make_connector_mesh(world.connectors[i], look, stage.body_models));
    const bool chain = look.kind == scenes::ConnectorLook::Kind::chain;
    const scenes::Material material{.name = chain ? "steel" : "rope",
                                    .base_color = {1, 1, 1},
                                    .roughness = chain ? 0.25f : 0.9f,
                                    .metallic = chain ? 1.0f : 0.0f};
    auto [triangles, rest] = connector_meshes_[i]->take_shape();
    if (!shape || shape->triangles() != triangles || !std::ranges::equal(shape->rest(), rest, same))
      shape = std::make_shared<const RestShape>(gl, std::move(triangles), std::move(rest));
    connectors_.emplace_back(gl, shape, material, chain ? Surface::plain : Surface::rope);
    if (const auto& winch = world.connectors[i].winch) {
      Winched added{.connector = i, .winch = winch, .length = world.connectors[i].length};
      for (std::size_t p = 0; p < world.pulleys.size(); ++p) {
        if (world.pulleys[p].to == i) added.enters = p;
        if (world.pulleys[p].from == i) added.leaves = p;
      }
      added.longer = added.paid_out(world.time, snapshot(world).passed)[1];
      winched_.push_back(std::move(added));
    }
  }
}

std::array<double, 2> MovingParts::Winched::paid_out(double time,
                                                     std::span<const double> passed) const {
  const auto at = [&](std::optional<std::size_t> pulley) {
    return pulley && *pulley < passed.size() ? passed[*pulley] : 0;
  };
  const double first = winch->paid_out(0, time).length + at(enters);
  const double last = winch->paid_out(1, time).length - at(leaves);
  return {first, first + last};
}

void MovingParts::pose(const FrameState& instant) {
  for (std::size_t i = 0; i < std::min(characters_.size(), instant.bones.size()); ++i) {
    const scenes::Model& model = *stage_.characters[i];
    const std::vector<mesh::BoneMatrix> bones = mesh::bone_matrices(model, instant.bones[i]);
    for (std::size_t k = 0; k < model.meshes.size(); ++k) {
      mesh::skin(model.meshes[k], bones, vertices_);
      characters_[i][k].move(vertices_);
    }
  }
  for (const Winched& at : winched_) {
    const auto [first, longer] = at.paid_out(instant.state.time, instant.state.passed);
    const double length = at.length + longer - at.longer;
    connectors_[at.connector].set_flow(
        {.paid_out = float(first), .length_ratio = float(length / at.length)});
  }
  for (std::size_t i = 0; i < connectors_.size(); ++i) {
    connectors_[i].follow(
        [&mesh = *connector_meshes_[i], &state = instant.state, i](auto& vertices) {
          mesh.place(state.connectors[i], state.bodies, vertices);
        });
  }
}

std::size_t MovingParts::triangles() const {
  std::size_t indices = 0;
  const auto add = [&](std::span<const Drawable> parts) {
    for (const Drawable& part : parts) indices += part.triangles().size();
  };
  for (const auto& body : bodies_) add(body);
  for (const auto& character : characters_) add(character);
  add(connectors_);
  return indices / 3;
}

std::vector<DrawItem> MovingParts::items(const FrameState& instant, const Layer& layer) {
  std::vector<DrawItem> items;
  if (layer.characters)
    for (auto& character : characters_)
      for (Drawable& part : character) items.emplace_back(part, Matrix4f::Identity());
  if (layer.bodies)
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      for (Drawable& part : bodies_[i]) items.emplace_back(part, matrix(instant.state.bodies[i]));
  if (layer.connectors)
    for (Drawable& connector : connectors_) items.emplace_back(connector, Matrix4f::Identity());
  return items;
}

Places places_of(const DrawItem& item) {
  const Eigen::Matrix3f turn = item.model.topLeftCorner<3, 3>();
  const Eigen::Vector3f at = item.model.topRightCorner<3, 1>();
  Places places;
  item.drawable->find_positions(places);
  for (Eigen::Vector3f& p : places) p = turn * p + at;
  return places;
}

void MovingParts::find_places(const FrameState& instant, std::size_t item, Places& places) {
  const auto take = [&] {
    places.clear();
    for (const mesh::MovingVertex& v : vertices_) places.push_back(v.position);
  };
  for (std::size_t i = 0; i < characters_.size(); item -= characters_[i++].size()) {
    if (item >= characters_[i].size()) continue;
    if (i >= instant.bones.size()) {  // it stays where it was last posed
      places = characters_[i][item].positions();
      return;
    }
    const scenes::Model& model = *stage_.characters[i];
    mesh::skin(model.meshes[item], mesh::bone_matrices(model, instant.bones[i]), vertices_);
    return take();
  }
  for (std::size_t i = 0; i < bodies_.size(); item -= bodies_[i++].size())
    if (item < bodies_[i].size()) {
      places = places_of({bodies_[i][item], matrix(instant.state.bodies[i])});
      return;
    }
  connector_meshes_[item]->place(instant.state.connectors[item], instant.state.bodies, vertices_);
  take();
}

Eigen::AlignedBox3d extent(const FrameState& instant) {
  Eigen::AlignedBox3d box;
  for (const auto& particles : instant.state.connectors)
    for (const Vec3& p : particles) box.extend(p);
  for (const Pose& body : instant.state.bodies) box.extend(body.position);
  for (const auto& bones : instant.bones)
    for (const Pose& bone : bones) box.extend(bone.position);
  if (box.isEmpty()) box.extend(Vec3::Zero());
  const Vec3 margin = Vec3::Constant(0.35);  // flesh around bones, sticks beyond their middles
  return {box.min() - margin, box.max() + margin};
}

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
  block.view_projection = moved_by(block.view_projection, viewport, shift);
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
      block.view_projection =
          moved_backdrop(moved_by(block.view_projection, viewport, parts.shift), viewport, i);
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
