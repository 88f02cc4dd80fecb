#include "render/export/gltf/gltf_connector.h"

#include <algorithm>
#include <cmath>

#include "render/mesh/chain_mesh.h"

namespace taut::exporting {
namespace {

Quat frame_of(const Vec3& x, const Vec3& y) {
  Mat3 axes;
  axes << x, y, x.cross(y);
  return Quat(axes);
}

scenes::Material material_of(const scenes::ConnectorLook& look) {
  const bool chain = look.kind == scenes::ConnectorLook::Kind::chain;
  return {.name = chain ? "steel" : "rope",
          .base_color = {1, 1, 1},
          .roughness = chain ? 0.25f : 0.9f,
          .metallic = chain ? 1.0f : 0.0f};
}

}  // namespace

GltfConnector::GltfConnector(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                             const scenes::ConnectorLook& look, std::span<const std::size_t> bodies,
                             std::span<const std::shared_ptr<const scenes::Model>> models) {
  const std::size_t group = file.add_node(connector.name);
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    particles_.push_back(file.add_node(connector.name + '.' + std::to_string(i), group));
    file.node(particles_.back())["extras"] = {{"particle", i}};
  }
  if (look.kind == scenes::ConnectorLook::Kind::chain) {
    add_chain(file, meshes, connector, look, bodies, models);
  } else {
    add_tube(file, meshes, connector, look);
  }
}

void GltfConnector::add_chain(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                              const scenes::ConnectorLook& look,
                              std::span<const std::size_t> bodies,
                              std::span<const std::shared_ptr<const scenes::Model>> models) {
  const mesh::ChainShape shape = mesh::chain_shape(connector.length, look.diameter);
  const scenes::Material steel = material_of(look);
  const auto mesh_of = [&](const char* what, mesh::Piece piece, double up) {
    for (mesh::MovingVertex& v : piece.vertices) v.position.y() += float(up);
    return meshes.of_mesh(connector.name + ' ' + what,
                          plain_mesh(piece.vertices, piece.indices, look.color.cast<float>()),
                          steel, false);
  };
  const std::size_t link_mesh = mesh_of("link", shape.link, shape.pitch / 2);
  const double spans = double(connector.particles() - 1);
  for (std::size_t k = 0; k < shape.links; ++k) {
    const double at = double(k) / double(shape.links) * spans;
    const auto particle = std::min(std::size_t(at + 1e-9), connector.particles() - 2);
    const std::size_t node =
        file.add_node(connector.name + " link " + std::to_string(k), particles_[particle]);
    file.node(node)["mesh"] = link_mesh;
    links_.push_back({node, particle, at - double(particle) > 1e-9});
  }
  std::optional<std::size_t> ring, collar;
  for (const bool last : {false, true}) {
    auto& mount = mounts_[last];
    mount = mesh::chain_mount(connector, last ? connector.particles() - 1 : 0, models);
    if (!mount) continue;
    if (!ring) {
      ring = mesh_of("eye", shape.ring, 0);
      collar = mesh_of("collar", shape.collar, 0);
    }
    // The eye hangs in the link, at right angles to it, beyond its end.
    const Link& link = last ? links_.back() : links_.front();
    const std::size_t eye = file.add_node(connector.name + " eye", link.node);
    file.node(eye)["mesh"] = *ring;
    const double out = last ? 1 : -1;
    file.place(eye, {Vec3(0, (last ? shape.pitch : 0) + out * shape.inset, 0),
                     frame_of(Vec3(0, 0, -out), Vec3(0, -out, 0))});
    const std::size_t on_body = file.add_node(connector.name + " collar", bodies[mount->body]);
    file.node(on_body)["mesh"] = *collar;
    const std::size_t particle = last ? connector.particles() - 1 : 0;
    for (const Hold& hold : connector.holds)
      if (hold.particle == particle)
        file.place(on_body, {hold.to.point, frame_of(mount->axis.unitOrthogonal(), mount->axis)});
  }
}

void GltfConnector::add_tube(GltfFile& file, GltfMeshes& meshes, const Connector& connector,
                             const scenes::ConnectorLook& look) {
  // The rest pose is straight along y.
  std::vector<Vec3> straight{Vec3::Zero()};
  for (const double rest : connector.rest)
    straight.push_back(straight.back() + rest * Vec3::UnitY());
  const auto shape = mesh::make_connector_mesh(connector, look, {});
  std::vector<mesh::MovingVertex> vertices;
  shape->place(straight, {}, vertices);
  scenes::Mesh mesh = plain_mesh(vertices, shape->indices(), Eigen::Vector3f::Ones());
  const double radius = look.diameter / 2, length = straight.back().y();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    scenes::Vertex& v = mesh.vertices[i];
    const Eigen::Vector3f& color = shape->rest()[i].color;
    v.color = {color.x(), color.y(), color.z()};
    const double y = v.position[1];
    const auto above =
        std::ranges::upper_bound(straight, y, {}, [](const Vec3& p) { return p.y(); });
    const auto next = std::clamp<std::ptrdiff_t>(above - straight.begin(), 1,
                                                 std::ptrdiff_t(straight.size()) - 1);
    const double low = straight[std::size_t(next - 1)].y(), high = straight[std::size_t(next)].y();
    const double share = high > low ? std::clamp((y - low) / (high - low), 0.0, 1.0) : 0;
    const auto bone = [](auto number) { return std::uint16_t(number); };
    v.bones = {bone(next - 1), bone(next), 0, 0};
    v.weights = {float(1 - share), float(share), 0, 0};
    // A weight at an end moves as one.
    if (std::hypot(v.position[0], v.position[2]) > 1.01 * radius || y < 0 || y > length) {
      v.bones = {bone(y < length / 2 ? 0 : straight.size() - 1), 0, 0, 0};
      v.weights = {1, 0, 0, 0};
    }
  }
  // Joints are there as the mesh was made: Blender's rest pose is that of the nodes, and a mesh
  // that is collapsed there has its normals from nowhere.
  for (std::size_t i = 0; i < straight.size(); ++i)
    file.place(particles_[i], {straight[i], Quat::Identity()});
  std::vector<float> inverse_bind;
  for (const Vec3& p : straight) {
    const float m[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -float(p.y()), 0, 1};
    inverse_bind.insert(inverse_bind.end(), std::begin(m), std::end(m));
  }
  const std::size_t skin = file.add(
      "skins", {{"inverseBindMatrices",
                 file.add_numbers(std::span<const float>(inverse_bind), {GltfFile::f32, "MAT4"})},
                {"joints", particles_}});
  const std::size_t node = file.add_node(connector.name + " tube");
  file.node(node)["mesh"] = meshes.of_mesh(connector.name, mesh, material_of(look), true);
  file.node(node)["skin"] = skin;
}

void GltfConnector::turn(std::span<const Vec3> particles, std::span<const Pose> bodies,
                         GltfMotion& motion) {
  if (links_.empty()) {
    turn_particles(particles, motion);
  } else {
    turn_links(particles, bodies, motion);
  }
}

void GltfConnector::turn_links(std::span<const Vec3> particles, std::span<const Pose> bodies,
                               GltfMotion& motion) const {
  const auto hold =
      [&](const std::optional<mesh::ChainMount>& mount) -> std::optional<mesh::ChainHold> {
    if (!mount) return {};
    const Quat& turn = bodies[mount->body].rotation;
    return mesh::ChainHold{turn * mount->axis, turn * mount->axis.unitOrthogonal()};
  };
  const std::vector<mesh::LinkFrame> frames =
      mesh::link_frames(particles, links_.size(), hold(mounts_[0]), hold(mounts_[1]));
  for (std::size_t k = 0; k < links_.size(); ++k) {
    motion.turn(links_[k].node, frame_of(frames[k].wide, frames[k].axis));
    if (links_[k].off)
      motion.translate(links_[k].node, frames[k].from - particles[links_[k].particle]);
  }
}

void GltfConnector::turn_particles(std::span<const Vec3> particles, GltfMotion& motion) {
  Vec3 axis = axis_, side = side_;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Vec3 along =
        particles[std::min(i + 1, particles.size() - 1)] - particles[i > 0 ? i - 1 : 0];
    const double length = along.norm();
    const Vec3 next = length > 1e-12 ? Vec3(along / length) : axis;
    side = mesh::transport(side, axis, next);
    axis = next;
    motion.turn(particles_[i], frame_of(side, axis));
    if (i == 0) {
      axis_ = axis;
      side_ = side;
    }
  }
}

}  // namespace taut::exporting
