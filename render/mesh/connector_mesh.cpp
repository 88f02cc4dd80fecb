#include "render/mesh/connector_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "render/mesh/chain_mesh.h"

namespace taut::mesh {
namespace {

using Vec3f = Eigen::Vector3f;

/// The radius (m) of the ball that a point mass at a particle is drawn as: as large as steel of
/// that mass. No ball where the particle is held or has only its share of the connector.
std::optional<float> weight_radius(const Connector& connector, std::size_t particle) {
  const double own = connector.mass / double(connector.particles());
  const double extra = connector.particle_mass[particle] - own;
  if (extra <= 1e-6 * own + 1e-12) return {};
  for (const Hold& hold : connector.holds)
    if (hold.particle == particle) return {};
  constexpr double kSteel = 7850;  // kg/m3
  return float(std::cbrt(3 * extra / (4 * std::numbers::pi * kSteel)));
}

/// The radius (m) of the ball at an end: of its weight, or of the knob where a path carries it.
std::optional<float> ball_radius(const Connector& connector, const scenes::ConnectorLook& look,
                                 std::size_t particle) {
  for (const Hold& hold : connector.holds)
    if (look.knob > 0 && hold.particle == particle && hold.to.kind == Attachment::Kind::path)
      return float(look.knob / 2);
  return weight_radius(connector, particle);
}

constexpr int kBallRows = 16;
constexpr std::uint32_t kBallSides = 32;

/// A ball of radius 1 m, which all weights share.
const Piece& unit_ball() {
  static const Piece ball = [] {
    std::vector<std::array<float, 4>> profile;
    for (int i = 0; i <= kBallRows; ++i) {
      const float angle = std::numbers::pi_v<float> * (float(i) / kBallRows - 0.5f);
      const float out = std::cos(angle), up = std::sin(angle);
      profile.push_back({out, up, out, up});
    }
    return turned_piece(profile, kBallSides);
  }();
  return ball;
}

/// Adds the vertices of a ball round `at` (m).
void add_ball(const Vec3f& at, float radius, std::vector<MovingVertex>& vertices) {
  const std::span<const MovingVertex> unit = unit_ball().vertices;
  const auto equator = unit.subspan(kBallRows / 2 * kBallSides, kBallSides);
  for (std::size_t k = 0; k < unit.size(); ++k) {
    const Vec3f& row = unit[k / kBallSides * kBallSides].position;  // where z is 0
    const Vec3f& direction = equator[k % kBallSides].position;
    const Vec3f out = radius * row.x() * direction;
    vertices.push_back({at + (out + Vec3f(0, radius * row.y(), 0)), unit[k].normal});
  }
}

/// How thick a connector is at its particles, as shares of where it is thickest: a taper.
std::vector<double> shares(const Connector& connector) {
  std::vector<double> result(connector.particles(), 1);
  const std::vector<Section>& links = connector.sections;
  const auto thick = [](const Section& a, const Section& b) { return a.diameter < b.diameter; };
  const double most = links.empty() ? 0 : std::ranges::max_element(links, thick)->diameter;
  if (most <= 0) return result;
  for (std::size_t i = 0; i < result.size(); ++i) {
    const Section &before = links[i > 0 ? i - 1 : 0], &after = links[std::min(i, links.size() - 1)];
    result[i] = (before.diameter + after.diameter) / (2 * most);
  }
  return result;
}

/// A tube through the particles: a Catmull-Rom curve with parallel-transport frames.
class TubeMesh final : public ConnectorMesh {
 public:
  TubeMesh(const Connector& connector, const scenes::ConnectorLook& look)
      : spans_(connector.particles() - 1),
        steps_(std::clamp<std::size_t>(120 / spans_, 1, 6)),
        rings_(spans_ * steps_ + 1) {
    const std::vector<double> thick = shares(connector);
    for (std::size_t i = 0; i < rings_; ++i) {
      const std::size_t before = std::min(i / steps_, spans_ - 1);
      const double u = double(i - before * steps_) / double(steps_);
      const double share = (1 - u) * thick[before] + u * thick[before + 1];
      radius_.push_back(float(share * look.diameter / 2));
    }
    const Vec3f color = look.color.cast<float>();
    for (std::size_t i = 0; i < rings_ + 2; ++i) {
      const std::size_t ring = std::clamp<std::size_t>(i, 1, rings_) - 1;
      const double share = double(ring) / double(rings_ - 1);
      for (std::uint32_t j = 0; j < kSides; ++j)
        rest_.push_back(
            {Vec3f(float(j) / kSides, float(share * connector.length), radius_[ring]), color});
    }
    add_grid(0, std::uint32_t(rings_ + 2), kSides, false, indices_);
    for (const std::size_t particle : {std::size_t(0), connector.particles() - 1}) {
      const std::optional<float> radius = ball_radius(connector, look, particle);
      if (!radius) continue;
      const auto first = std::uint32_t(rest_.size());
      for (const std::uint32_t i : unit_ball().indices) indices_.push_back(first + i);
      // On the crest of a strand everywhere, of a rope without end: its pattern leaves the ball
      // plain.
      rest_.resize(rest_.size() + unit_ball().vertices.size(),
                   {Vec3f(1 / 6.0f, 0, 1e9f), look.weight_color.cast<float>()});
      weights_.push_back({particle, *radius});
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
      axis = next;
      // The ends are closed by rings shrunk to a point.
      if (i == 0) ring(point, side, axis, 0, -axis, vertices);
      ring(point, side, axis, radius_[i], Vec3::Zero(), vertices);
      if (i + 1 == rings_) ring(point, side, axis, 0, axis, vertices);
    }
    for (const auto& [particle, radius] : weights_)
      add_ball(particles[particle].cast<float>(), radius, vertices);
  }

 private:
  static constexpr std::uint32_t kSides = 10;

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

  /// Cosine and sine of each corner of a ring.
  static const std::array<std::pair<float, float>, kSides>& corners() {
    static const auto all = [] {
      std::array<std::pair<float, float>, kSides> result;
      for (std::uint32_t j = 0; j < kSides; ++j) {
        const float angle = kTurn * float(j) / float(kSides);
        result[j] = {std::cos(angle), std::sin(angle)};
      }
      return result;
    }();
    return all;
  }

  static void ring(const Vec3& point, const Vec3& side, const Vec3& axis, float radius,
                   const Vec3& cap, std::vector<MovingVertex>& vertices) {
    const Vec3f x = side.cast<float>(), y = axis.cross(side).cast<float>();
    const Vec3f at = point.cast<float>(), end = cap.cast<float>();
    for (const auto& [cosine, sine] : corners()) {
      const Vec3f normal = cosine * x + sine * y;
      vertices.push_back({at + radius * normal, radius > 0 ? normal : end});
    }
  }

  struct Weight {
    std::size_t particle;
    float radius;  // m
  };

  std::vector<float> radius_;  // m, of each ring
  std::vector<Weight> weights_;
  std::size_t spans_, steps_, rings_;
};

}  // namespace

std::unique_ptr<ConnectorMesh> make_connector_mesh(
    const Connector& connector, const scenes::ConnectorLook& look,
    std::span<const std::shared_ptr<const scenes::Model>> bodies) {
  if (look.kind == scenes::ConnectorLook::Kind::chain)
    return std::make_unique<ChainMesh>(connector, look, bodies);
  return std::make_unique<TubeMesh>(connector, look);
}

}  // namespace taut::mesh
