#include "render/draw/moving_parts.h"

#include <algorithm>

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

}  // namespace taut::draw
