// Connectors as geometry: chains of real links between swivels, ropes and cords as tubes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scenes/scene/stage.h"
#include "sim/motion/types.h"
#include "sim/world/connector.h"

namespace taut::mesh {

// A chain: real links between two swivels.

// Geometry whose triangles stay while its vertices move.

/// A vertex that moves every frame.
struct MovingVertex {
  Eigen::Vector3f position, normal;
};

/// A vertex's part that never changes: where the surface pattern is, and the tint.
struct RestVertex {
  Eigen::Vector3f rest;
  Eigen::Vector3f color;
};

/// Geometry of one connector, whose triangles never change while its vertices follow the particles.
/// Everything is placed by the share of the connector's length, never by measured distances, so
/// that nothing pops in or out when it snaps taut or is stretched by its method.
class ConnectorMesh {
 public:
  virtual ~ConnectorMesh() = default;

  const std::vector<std::uint32_t>& indices() const { return indices_; }
  const std::vector<RestVertex>& rest() const { return rest_; }
  /// Both, for one who keeps them elsewhere; none are here afterwards.
  std::pair<std::vector<std::uint32_t>, std::vector<RestVertex>> take_shape() {
    return {std::move(indices_), std::move(rest_)};
  }
  /// The vertices for these particles (m, world) and the frames of the bodies.
  virtual void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
                     std::vector<MovingVertex>& vertices) const = 0;

 protected:
  std::vector<std::uint32_t> indices_;
  std::vector<RestVertex> rest_;
};

// Where the links of a chain are, and how they are turned about their own length.

/// The hold of a chain's end: a direction away from it, and one across, both unit vectors.
struct ChainHold {
  Vec3 axis, side;
};

/// A link between two joints. Neighbouring links are turned against one another by 90 degrees.
struct LinkFrame {
  Vec3 from, to;  // m
  Vec3 axis;      // from the one to the other, unit
  Vec3 wide;      // across the flat side, unit

  Vec3 middle() const { return (from + to) / 2; }
};

/// `links` links along the particles, each of the same share of the connector's length. They are
/// functions of these positions alone. Parallel transport from link to link would turn a link fast
/// and far about itself where its neighbour is folded back nearly onto it, and the fold moves: it
/// follows a smoothed direction instead, which folds widely, and each link is turned out of that by
/// the shortest way. The holds of the ends count as links.
std::vector<LinkFrame> link_frames(std::span<const Vec3> particles, std::size_t links,
                                   const std::optional<ChainHold>& first,
                                   const std::optional<ChainHold>& last);

/// The rotation that turns unit vector `from` onto unit vector `to` by the shortest way, applied to
/// `v`: parallel transport along a bend. Across `to` where `v` was across `from`, to rounding.
Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to);

// Hard geometry that is drawn many times: wires bent to closed curves, bodies of revolution.

inline constexpr float kTurn = 2 * std::numbers::pi_v<float>;  // rad

/// A closed or open grid of quads, `rows` rings of `sides` vertices each, as triangles that face
/// outwards where the rings turn right-handedly about the direction of their succession.
void add_grid(std::uint32_t first, std::uint32_t rows, std::uint32_t sides, bool closed,
              std::vector<std::uint32_t>& indices);

struct Piece {
  std::vector<MovingVertex> vertices;
  std::vector<std::uint32_t> indices;
};

/// One chain link along y: two straight sides and two half circles about (0, +-half_pitch).
/// `width` is the outer width, `wire` the wire's radius.
Piece link_piece(float half_pitch, float width, float wire);

/// A ring about z.
Piece ring_piece(float radius, float wire);

/// A body of revolution about y from (radius, height) points, lowest first, with their normals.
Piece turned_piece(std::span<const std::array<float, 4>> profile, std::uint32_t sides);

/// The shape of a chain.
struct ChainShape {
  std::size_t links;
  double width;  // of a link, outside, m
  double pitch;  // from one link to the next, m
  double inset;  // of a swivel's eye, from where the first link begins, m
  Piece link, ring, collar;
};
ChainShape chain_shape(double length, double width);

/// The body that holds an end of a chain, the direction out of it, in its frame, and how thick it
/// is there.
struct ChainMount {
  std::size_t body;
  Vec3 axis;
  double radius;  // m; 0: it has no model
};
std::optional<ChainMount> chain_mount(const Connector& connector, std::size_t particle,
                                      std::span<const std::shared_ptr<const scenes::Model>> bodies);

class ChainMesh final : public ConnectorMesh {
 public:
  ChainMesh(const Connector& connector, const scenes::ConnectorLook& look,
            std::span<const std::shared_ptr<const scenes::Model>> bodies);

  void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
             std::vector<MovingVertex>& vertices) const override;

 private:
  void add(const Piece& piece, const Eigen::Vector3f& color);
  /// The eye that the end's link hangs in (at right angles to the link) and the collar below it;
  /// `outwards` is the link's direction away from the mount, `wide` its wide side.
  void put_swivel(const ChainMount& mount, const Vec3& point, const Vec3& outwards,
                  const Vec3& wide, std::span<const Pose> bodies,
                  std::vector<MovingVertex>& vertices) const;

  std::array<std::optional<ChainMount>, 2> mounts_;
  ChainShape shape_;
};

// A chain lies on what it hangs on.

/// The end of a round bar that a chain hangs on, for the middles of its links: they stay out of it.
struct BarEnd {
  Vec3 top;         // where the chain is attached, m
  Vec3 axis;        // out of the bar, unit
  double radius;    // m
  double rounding;  // m, of the rim
};

/// How far a point is outside; negative inside.
double distance(const BarEnd& bar, const Vec3& point);

/// The points of a chain, those inside bars moved out, their neighbours along with them, so that
/// links keep their lengths where the chain has slack enough. The first and the last point stay,
/// and so do all where none is inside. Simulations know no such contact: pictures lay a cord around
/// a ferrule that it passes through.
std::vector<Vec3> clear_of(std::span<const BarEnd> bars, std::span<const Vec3> points);

/// The geometry of `connector`, drawn as `look` says; its holds tell where swivels sit on bodies,
/// whose models (null: none) tell how thick they are there.
std::unique_ptr<ConnectorMesh> make_connector_mesh(
    const Connector& connector, const scenes::ConnectorLook& look,
    std::span<const std::shared_ptr<const scenes::Model>> bodies);

}  // namespace taut::mesh
