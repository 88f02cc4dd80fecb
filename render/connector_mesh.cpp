#include "render/connector_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace taut {
namespace {

using Vec3f = Eigen::Vector3f;
constexpr float kTurn = 2 * std::numbers::pi_v<float>;

/// A closed or open grid of quads, `rows` rings of `sides` vertices each, as triangles that face
/// outwards where the rings turn right-handedly about the direction of their succession.
void add_grid(std::uint32_t first, std::uint32_t rows, std::uint32_t sides, bool closed,
              std::vector<std::uint32_t>& indices) {
  const std::uint32_t bands = closed ? rows : rows - 1;
  for (std::uint32_t i = 0; i < bands; ++i) {
    const std::uint32_t a = first + i * sides, b = first + (i + 1) % rows * sides;
    for (std::uint32_t j = 0; j < sides; ++j) {
      const std::uint32_t k = (j + 1) % sides;
      for (const std::uint32_t v : {a + j, a + k, b + j, b + j, a + k, b + k}) indices.push_back(v);
    }
  }
}

/// The rotation that turns unit vector `from` onto unit vector `to` by the shortest way, applied to
/// `v`: parallel transport along a bend.
Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to) {
  return Quat::FromTwoVectors(from, to) * v;
}

/// A unit vector across `axis`.
Vec3 across(const Vec3& axis) {
  return axis.unitOrthogonal();
}

/// A point at `share` (0 to 1) of the connector's length, linearly between particles.
Vec3 along(std::span<const Vec3> particles, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * double(particles.size() - 1);
  const std::size_t i = std::min(std::size_t(at), particles.size() - 2);
  const double u = at - double(i);
  return (1 - u) * particles[i] + u * particles[i + 1];
}

/// Where an end is held: a body and a point on it, or nothing that can be seen.
struct Mount {
  bool on_body = false;
  std::size_t body = 0;
  Vec3 axis = Vec3::UnitY();  // out of the body, in its frame
};

Mount mount_at(const Connector& connector, std::size_t particle) {
  for (const Hold& hold : connector.holds)
    if (hold.particle == particle && hold.to.kind == Attachment::Kind::body) {
      const double length = hold.to.point.norm();
      return {true, hold.to.body, length > 1e-9 ? Vec3(hold.to.point / length) : Vec3::UnitY()};
    }
  return {};
}

/// A piece of hard geometry that is drawn many times, each with its own frame.
struct Piece {
  std::vector<MovingVertex> vertices;
  std::vector<std::uint32_t> indices;
};

/// A wire of circular section along a closed curve in the x-y plane, the curve's tangent given.
template <typename Curve>
Piece bent_wire(float radius, std::uint32_t steps, std::uint32_t sides, Curve curve) {
  Piece piece;
  for (std::uint32_t i = 0; i < steps; ++i) {
    const auto [centre, outwards] = curve(float(i) / float(steps));
    for (std::uint32_t j = 0; j < sides; ++j) {
      const float angle = kTurn * float(j) / float(sides);
      const Vec3f normal = std::cos(angle) * outwards - std::sin(angle) * Vec3f::UnitZ();
      piece.vertices.push_back({centre + radius * normal, normal});
    }
  }
  add_grid(0, steps, sides, true, piece.indices);
  return piece;
}

/// One chain link along y: two straight sides and two half circles about (0, +-half_pitch).
/// `width` is the outer width, `wire` the wire's radius.
Piece link_piece(float half_pitch, float width, float wire) {
  const float bend = width / 2 - wire;
  constexpr std::uint32_t kBendSteps = 8, kSteps = 2 * kBendSteps;
  // The curve's points sit only on the two bends, whose ends the straight sides join; their centres
  // are a little inside, so that the inner sides of two joined links touch.
  const float centre = std::max(half_pitch + wire - bend, 0.0f);
  return bent_wire(wire, kSteps, 8, [=](float t) {
    const auto i = std::uint32_t(std::lround(t * float(kSteps)));
    const bool top = i < kBendSteps;
    const float angle = std::numbers::pi_v<float> *
                        (float(i % kBendSteps) / float(kBendSteps - 1) + (top ? 0.0f : 1.0f));
    const Vec3f outwards(std::cos(angle), std::sin(angle), 0);
    return std::pair(Vec3f(bend * outwards + Vec3f(0, top ? centre : -centre, 0)), outwards);
  });
}

/// A ring about z.
Piece ring_piece(float radius, float wire) {
  return bent_wire(wire, 16, 8, [=](float t) {
    const Vec3f outwards(std::cos(kTurn * t), std::sin(kTurn * t), 0);
    return std::pair(Vec3f(radius * outwards), outwards);
  });
}

/// A body of revolution about y from (radius, height) points, lowest first, with their normals.
Piece turned_piece(std::span<const std::array<float, 4>> profile, std::uint32_t sides) {
  Piece piece;
  for (const auto& [radius, height, out, up] : profile)
    for (std::uint32_t j = 0; j < sides; ++j) {
      const float angle = -kTurn * float(j) / float(sides);
      const Vec3f direction(std::cos(angle), 0, std::sin(angle));
      piece.vertices.push_back({radius * direction + Vec3f(0, height, 0),
                                (out * direction + Vec3f(0, up, 0)).normalized()});
    }
  add_grid(0, std::uint32_t(profile.size()), sides, false, piece.indices);
  return piece;
}

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

class ChainMesh final : public ConnectorMesh {
 public:
  ChainMesh(const Connector& connector, const ConnectorLook& look)
      : mounts_{mount_at(connector, 0), mount_at(connector, connector.particles() - 1)} {
    const auto width = float(look.diameter);
    const float wire = 0.19f * width;
    // Links 1.8 times as long as wide; joined, each takes its length less two wires.
    const double pitch = 1.8 * width - 4 * wire;
    links_ = std::max<std::size_t>(std::size_t(std::lround(connector.length / pitch)), 1);
    pitch_ = connector.length / double(links_);
    link_ = link_piece(float(pitch_ / 2), width, wire);
    ring_ = ring_piece(width / 2 - wire, wire);
    inset_ = width / 2 - 2 * wire;
    collar_ = collar_piece(width);
    const Vec3f color = look.color.cast<float>();
    for (std::size_t i = 0; i < links_; ++i) add(link_, color);
    for (const Mount& mount : mounts_)
      if (mount.on_body) {
        add(ring_, color);
        add(collar_, color);
      }
  }

  void place(std::span<const Vec3> particles, std::span<const Pose> bodies,
             std::vector<MovingVertex>& vertices) const override {
    vertices.clear();
    Vec3 axis = Vec3::UnitY(), side = Vec3::UnitX();
    if (mounts_[0].on_body) {
      const Quat& turn = bodies[mounts_[0].body].rotation;
      axis = turn * mounts_[0].axis;
      side = turn * across(mounts_[0].axis);
    }
    Vec3 first_axis = axis, first_side = side;
    Vec3 from = along(particles, 0);
    for (std::size_t i = 0; i < links_; ++i) {
      const Vec3 to = along(particles, double(i + 1) / double(links_));
      const double gap = (to - from).norm();
      const Vec3 next = gap > 1e-9 ? Vec3((to - from) / gap) : axis;
      side = transport(side, axis, next);
      side = (side - side.dot(next) * next).normalized();
      axis = next;
      if (i == 0) first_axis = axis, first_side = side;
      // Neighbouring links stand at right angles. A link that its method stretched is drawn so.
      const Vec3 wide = i % 2 ? Vec3(axis.cross(side)) : side;
      put(link_, (from + to) / 2, wide, axis, std::max(gap / pitch_, 1.0), vertices);
      from = to;
    }
    put_swivel(mounts_[0], particles.front(), first_axis, first_side.cross(first_axis), bodies,
               vertices);
    const Vec3 last_wide = links_ % 2 ? Vec3(axis.cross(side)) : side;
    put_swivel(mounts_[1], particles.back(), -axis, last_wide, bodies, vertices);
  }

 private:
  void add(const Piece& piece, const Vec3f& color) {
    const auto first = std::uint32_t(rest_.size());
    for (const std::uint32_t i : piece.indices) indices_.push_back(first + i);
    for (const MovingVertex& v : piece.vertices) rest_.push_back({v.position, color});
  }

  /// `piece` with its x along `wide`, its y along `axis` and stretched along y.
  static void put(const Piece& piece, const Vec3& origin, const Vec3& wide, const Vec3& axis,
                  double stretch, std::vector<MovingVertex>& vertices) {
    Mat3 frame;
    frame << wide, axis, wide.cross(axis);
    const Eigen::Matrix3f turn = frame.cast<float>();
    const Vec3f at = origin.cast<float>();
    const auto k = float(stretch);
    for (const MovingVertex& v : piece.vertices)
      vertices.push_back(
          {at + turn * Vec3f(v.position.x(), k * v.position.y(), v.position.z()), turn * v.normal});
  }

  /// The eye that the end's link hangs in (at right angles to the link) and the collar below it.
  void put_swivel(const Mount& mount, const Vec3& point, const Vec3& outwards, const Vec3& wide,
                  std::span<const Pose> bodies, std::vector<MovingVertex>& vertices) const {
    if (!mount.on_body) return;
    // The link's wire passes the held point on one side of it, the eye's on the other.
    put(ring_, point - inset_ * outwards, wide, outwards, 1, vertices);
    const Vec3 axis = bodies[mount.body].rotation * mount.axis;
    put(collar_, point, across(axis), axis, 1, vertices);
  }

  std::array<Mount, 2> mounts_;
  std::size_t links_ = 0;
  double pitch_ = 0, inset_ = 0;
  Piece link_, ring_, collar_;
};

/// The ball that a point mass at a particle is drawn as: as large as steel of that mass. No ball
/// where the particle is held or has only its share of the connector.
std::optional<Piece> weight_piece(const Connector& connector, std::size_t particle) {
  const double own = connector.mass / double(connector.particles());
  const double extra = connector.particle_mass[particle] - own;
  if (extra <= 1e-6 * own + 1e-12) return {};
  for (const Hold& hold : connector.holds)
    if (hold.particle == particle) return {};
  constexpr double kSteel = 7850;  // kg/m3
  const auto radius = float(std::cbrt(3 * extra / (4 * std::numbers::pi * kSteel)));
  constexpr int kRows = 16;
  std::vector<std::array<float, 4>> profile;
  for (int i = 0; i <= kRows; ++i) {
    const float angle = std::numbers::pi_v<float> * (float(i) / kRows - 0.5f);
    const float out = std::cos(angle), up = std::sin(angle);
    profile.push_back({radius * out, radius * up, out, up});
  }
  return turned_piece(profile, 32);
}

/// A tube through the particles: a Catmull-Rom curve with parallel-transport frames.
class TubeMesh final : public ConnectorMesh {
 public:
  TubeMesh(const Connector& connector, const ConnectorLook& look)
      : radius_(float(look.diameter / 2)),
        spans_(connector.particles() - 1),
        steps_(std::clamp<std::size_t>(120 / spans_, 1, 6)),
        rings_(spans_ * steps_ + 1) {
    const Vec3f color = look.color.cast<float>();
    for (std::size_t i = 0; i < rings_ + 2; ++i) {
      const double share = std::clamp(double(i) - 1, 0.0, double(rings_ - 1)) / double(rings_ - 1);
      for (std::uint32_t j = 0; j < kSides; ++j)
        rest_.push_back(
            {Vec3f(float(j) / kSides, float(share * connector.length), radius_), color});
    }
    add_grid(0, std::uint32_t(rings_ + 2), kSides, false, indices_);
    for (const std::size_t particle : {std::size_t(0), connector.particles() - 1}) {
      const std::optional<Piece> weight = weight_piece(connector, particle);
      if (!weight) continue;
      const auto first = std::uint32_t(rest_.size());
      for (const std::uint32_t i : weight->indices) indices_.push_back(first + i);
      // On the crest of a strand everywhere: the rope's pattern leaves the ball plain.
      rest_.resize(rest_.size() + weight->vertices.size(), {Vec3f(1 / 6.0f, 0, 1), kIron});
      weights_.push_back({particle, *weight});
    }
  }

  void place(std::span<const Vec3> particles, std::span<const Pose>,
             std::vector<MovingVertex>& vertices) const override {
    vertices.clear();
    Vec3 axis = Vec3::UnitY(), side = Vec3::UnitX();
    for (std::size_t i = 0; i < rings_; ++i) {
      const auto [point, slope] = curve(particles, i);
      const double speed = slope.norm();
      const Vec3 next = speed > 1e-12 ? Vec3(slope / speed) : axis;
      side = transport(side, axis, next);
      side = (side - side.dot(next) * next).normalized();
      axis = next;
      // The ends are closed by rings shrunk to a point.
      if (i == 0) ring(point, side, axis, 0, -axis, vertices);
      ring(point, side, axis, radius_, Vec3::Zero(), vertices);
      if (i + 1 == rings_) ring(point, side, axis, 0, axis, vertices);
    }
    for (const auto& [particle, weight] : weights_) {
      const Vec3f at = particles[particle].cast<float>();
      for (const MovingVertex& v : weight.vertices) vertices.push_back({at + v.position, v.normal});
    }
  }

 private:
  static constexpr std::uint32_t kSides = 10;
  inline static const Vec3f kIron{0.05f, 0.055f, 0.065f};

  std::pair<Vec3, Vec3> curve(std::span<const Vec3> p, std::size_t ring) const {
    const std::size_t i = std::min(ring / steps_, spans_ - 1);
    const double u = double(ring - i * steps_) / double(steps_);
    const Vec3 &b = p[i], &c = p[i + 1];
    const Vec3 a = i > 0 ? p[i - 1] : Vec3(2 * b - c),
               d = i + 2 < p.size() ? p[i + 2] : Vec3(2 * c - b);
    const Vec3 m = (c - a) / 2, n = (d - b) / 2;
    const double u2 = u * u, u3 = u2 * u;
    return {
        (2 * u3 - 3 * u2 + 1) * b + (u3 - 2 * u2 + u) * m + (3 * u2 - 2 * u3) * c + (u3 - u2) * n,
        (6 * u2 - 6 * u) * (b - c) + (3 * u2 - 4 * u + 1) * m + (3 * u2 - 2 * u) * n};
  }

  static void ring(const Vec3& point, const Vec3& side, const Vec3& axis, float radius,
                   const Vec3& cap, std::vector<MovingVertex>& vertices) {
    const Vec3f x = side.cast<float>(), y = axis.cross(side).cast<float>();
    const Vec3f at = point.cast<float>(), end = cap.cast<float>();
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const float angle = kTurn * float(j) / float(kSides);
      const Vec3f normal = std::cos(angle) * x + std::sin(angle) * y;
      vertices.push_back({at + radius * normal, radius > 0 ? normal : end});
    }
  }

  struct Weight {
    std::size_t particle;
    Piece piece;
  };

  float radius_;
  std::vector<Weight> weights_;
  std::size_t spans_, steps_, rings_;
};

}  // namespace

std::unique_ptr<ConnectorMesh> make_connector_mesh(const Connector& connector,
                                                   const ConnectorLook& look) {
  if (look.kind == ConnectorLook::Kind::chain) return std::make_unique<ChainMesh>(connector, look);
  return std::make_unique<TubeMesh>(connector, look);
}

}  // namespace taut
