#include "render/mesh/chain_mesh.h"

#include <algorithm>
#include <cmath>

#include "render/mesh/chain_contact.h"

namespace taut::mesh {
namespace {

using Vec3f = Eigen::Vector3f;

/// The collar that a swivel's eye turns in, `size` being the chain's outer width.
Piece collar_piece(float size) {
  const float r = 0.62f * size, h = 0.35f * size;
  const std::array<float, 4> profile[] = {{r, -h, 1, 0},
                                          {r, 0, 1, 0},
                                          {0.8f * r, 0.5f * h, 0.7f, 0.7f},
                                          {0.3f * r, 0.75f * h, 0.2f, 1},
                                          {0, 0.75f * h, 0, 1}};
  return turned_piece(profile, 16);
}

/// The radius (m) of a model round the axis on which the chain is attached, not far below that.
double thickness(const scenes::Model& model, const Vec3& point, const Vec3& axis) {
  constexpr double kBelow = 0.02;  // m
  double radius = 0;
  for (const scenes::Mesh& mesh : model.meshes)
    for (const scenes::Vertex& v : mesh.vertices) {
      const Vec3 r = Vec3(v.position[0], v.position[1], v.position[2]) - point;
      if (r.dot(axis) > -kBelow) radius = std::max(radius, (r - r.dot(axis) * axis).norm());
    }
  return radius;
}

/// `piece` with its x along `wide`, its y along `axis` and stretched along y.
void put(const Piece& piece, const Vec3& origin, const Vec3& wide, const Vec3& axis, double stretch,
         std::vector<MovingVertex>& vertices) {
  Mat3 frame;
  frame << wide, axis, wide.cross(axis);
  const Eigen::Matrix3f turn = frame.cast<float>();
  const Vec3f at = origin.cast<float>();
  const auto k = float(stretch);
  for (const MovingVertex& v : piece.vertices)
    vertices.push_back(
        {at + turn * Vec3f(v.position.x(), k * v.position.y(), v.position.z()), turn * v.normal});
}

}  // namespace

ChainShape chain_shape(double length, double diameter) {
  const auto width = float(diameter);
  const float wire = 0.19f * width;
  // Links 2.2 times as long as wide; joined, each takes its length less two wires' thickness.
  const std::size_t links =
      std::max<std::size_t>(std::size_t(std::lround(length / (2.2 * width - 4 * wire))), 1);
  const double pitch = length / double(links);
  return {links,
          diameter,
          pitch,
          width / 2 - 2 * wire,
          link_piece(float(pitch / 2), width, wire),
          ring_piece(width / 2 - wire, wire),
          collar_piece(width)};
}

std::optional<ChainMount> chain_mount(
    const Connector& connector, std::size_t particle,
    std::span<const std::shared_ptr<const scenes::Model>> bodies) {
  for (const Hold& hold : connector.holds)
    if (hold.particle == particle && hold.to.kind == Attachment::Kind::body) {
      const Vec3& point = hold.to.point;
      const double length = point.norm();
      const Vec3 axis = length > 1e-9 ? Vec3(point / length) : Vec3::UnitY();
      const bool known = hold.to.body < bodies.size() && bodies[hold.to.body];
      return ChainMount{hold.to.body, axis,
                        known ? thickness(*bodies[hold.to.body], point, axis) : 0};
    }
  return {};
}

ChainMesh::ChainMesh(const Connector& connector, const scenes::ConnectorLook& look,
                     std::span<const std::shared_ptr<const scenes::Model>> bodies)
    : mounts_{chain_mount(connector, 0, bodies),
              chain_mount(connector, connector.particles() - 1, bodies)},
      shape_(chain_shape(connector.length, look.diameter)) {
  const Vec3f color = look.color.cast<float>();
  for (std::size_t i = 0; i < shape_.links; ++i) add(shape_.link, color);
  for (const auto& mount : mounts_)
    if (mount) {
      add(shape_.ring, color);
      add(shape_.collar, color);
    }
}

void ChainMesh::place(std::span<const Vec3> particles, std::span<const Pose> bodies,
                      std::vector<MovingVertex>& vertices) const {
  vertices.clear();
  const auto hold = [&](const std::optional<ChainMount>& mount) -> std::optional<ChainHold> {
    if (!mount) return {};
    const Quat& turn = bodies[mount->body].rotation;
    return ChainHold{turn * mount->axis, turn * mount->axis.unitOrthogonal()};
  };
  std::vector<BarEnd> bars;
  for (const auto& [mount, point] :
       {std::pair(mounts_[0], particles.front()), {mounts_[1], particles.back()}})
    if (mount && mount->radius > 0)
      bars.push_back({point, bodies[mount->body].rotation * mount->axis,
                      mount->radius + 0.3 * shape_.width, 0.5 * shape_.width});
  const std::vector<LinkFrame> links =
      link_frames(clear_of(bars, particles), shape_.links, hold(mounts_[0]), hold(mounts_[1]));
  for (const LinkFrame& link : links) {
    // A link that its method stretched is drawn so.
    const double stretch = std::max((link.to - link.from).norm() / shape_.pitch, 1.0);
    put(shape_.link, link.middle(), link.wide, link.axis, stretch, vertices);
  }
  const LinkFrame &first = links.front(), &last = links.back();
  if (mounts_[0]) put_swivel(*mounts_[0], first.from, first.axis, first.wide, bodies, vertices);
  if (mounts_[1]) put_swivel(*mounts_[1], last.to, -last.axis, last.wide, bodies, vertices);
}

void ChainMesh::add(const Piece& piece, const Vec3f& color) {
  const auto first = std::uint32_t(rest_.size());
  for (const std::uint32_t i : piece.indices) indices_.push_back(first + i);
  for (const MovingVertex& v : piece.vertices) rest_.push_back({v.position, color});
}

void ChainMesh::put_swivel(const ChainMount& mount, const Vec3& point, const Vec3& outwards,
                           const Vec3& wide, std::span<const Pose> bodies,
                           std::vector<MovingVertex>& vertices) const {
  // The link's wire passes the held point on one side of it, the eye's on the other.
  put(shape_.ring, point - shape_.inset * outwards, wide.cross(outwards), outwards, 1, vertices);
  const Vec3 axis = bodies[mount.body].rotation * mount.axis;
  put(shape_.collar, point, axis.unitOrthogonal(), axis, 1, vertices);
}

}  // namespace taut::mesh
