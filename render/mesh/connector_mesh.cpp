#include "render/mesh/connector_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "sim/motion/rotation.h"

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

namespace {

/// Links, the deviation of the smoothing. At 2 the nunchaku's links turn about themselves no faster
/// than they swing; above, neighbours in a fold stand ever less at right angles.
constexpr double kSmooth = 2;

/// A point at `share` (0 to 1) of the connector's length, linearly between particles.
Vec3 along(std::span<const Vec3> particles, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * double(particles.size() - 1);
  const std::size_t i = std::min(std::size_t(at), particles.size() - 2);
  const double u = at - double(i);
  return (1 - u) * particles[i] + u * particles[i + 1];
}

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 1e-9 ? Vec3(v / length) : otherwise;
}

}  // namespace

Vec3 transport(const Vec3& v, const Vec3& from, const Vec3& to) {
  const Vec3 turned = rotation_between(from, to) * v;
  return (turned - turned.dot(to) * to).normalized();
}

std::vector<LinkFrame> link_frames(std::span<const Vec3> particles, std::size_t links,
                                   const std::optional<ChainHold>& first,
                                   const std::optional<ChainHold>& last) {
  std::vector<LinkFrame> frames(links);
  std::vector<Vec3> directions;  // of the links, and of what holds the ends
  if (first) directions.push_back(first->axis);
  const std::size_t offset = directions.size();
  for (std::size_t i = 0; i < links; ++i) {
    LinkFrame& link = frames[i];
    link.from = along(particles, double(i) / double(links));
    link.to = along(particles, double(i + 1) / double(links));
    link.axis =
        unit_or(link.to - link.from, directions.empty() ? Vec3::UnitY() : directions.back());
    directions.push_back(link.axis);
  }
  if (last) directions.push_back(-last->axis);

  Vec3 smooth = first ? first->axis : frames[0].axis;
  Vec3 side = first ? first->side : smooth.unitOrthogonal();
  for (std::size_t i = 0; i < links; ++i) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < directions.size(); ++k) {
      const double apart = (double(k) - double(i + offset)) / kSmooth;
      sum += std::exp(-apart * apart / 2) * directions[k];
    }
    const Vec3 next = unit_or(sum, smooth);
    side = transport(side, smooth, next);
    smooth = next;
    LinkFrame& link = frames[i];
    const Vec3 own = transport(side, smooth, link.axis);
    link.wide = i % 2 ? Vec3(link.axis.cross(own)) : own;
  }
  return frames;
}

namespace {

using Vec3f = Eigen::Vector3f;

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

}  // namespace

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

Piece ring_piece(float radius, float wire) {
  return bent_wire(wire, 16, 8, [=](float t) {
    const Vec3f outwards(std::cos(kTurn * t), std::sin(kTurn * t), 0);
    return std::pair(Vec3f(radius * outwards), outwards);
  });
}

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

namespace {

constexpr int kRounds = 40;

/// A point as a bar sees it: out from the rim's rounding (x) and up from it (y), and the direction
/// out of the axis.
struct Seen {
  double x, y;
  Vec3 out;
};

Seen seen(const BarEnd& bar, const Vec3& point) {
  const Vec3 r = point - bar.top;
  const double up = r.dot(bar.axis);
  const Vec3 out = r - up * bar.axis;
  const double radius = out.norm();
  return {radius - (bar.radius - bar.rounding), up + bar.rounding,
          radius > 1e-9 ? Vec3(out / radius) : bar.axis.unitOrthogonal()};
}

void push_out(const BarEnd& bar, Vec3& point) {
  const double depth = -distance(bar, point);
  if (depth <= 0) return;
  const auto [x, y, out] = seen(bar, point);
  if (x > 0 && y > 0) {
    point += depth * (x * out + y * bar.axis).normalized();
  } else {
    point += depth * (x > y ? out : bar.axis);
  }
}

}  // namespace

double distance(const BarEnd& bar, const Vec3& point) {
  const auto [x, y, out] = seen(bar, point);
  return std::min(std::max(x, y), 0.0) + std::hypot(std::max(x, 0.0), std::max(y, 0.0)) -
         bar.rounding;
}

std::vector<Vec3> clear_of(std::span<const BarEnd> bars, std::span<const Vec3> points) {
  std::vector<Vec3> moved(points.begin(), points.end());
  const std::size_t last = points.size() - 1;
  bool inside = false;
  for (std::size_t i = 1; i < last; ++i)
    for (const BarEnd& bar : bars) inside = inside || distance(bar, points[i]) < 0;
  for (int round = 0; inside && round < kRounds; ++round) {
    for (std::size_t i = 0; i < last; ++i) {
      const Vec3 link = moved[i + 1] - moved[i];
      const double length = (points[i + 1] - points[i]).norm(), now = link.norm();
      if (now < 1e-12) continue;
      const Vec3 miss = (1 - length / now) * link;
      const double first = i == 0 ? 0 : 1, second = i + 1 == last ? 0 : 1;
      if (first + second == 0) continue;
      moved[i] += first / (first + second) * miss;
      moved[i + 1] -= second / (first + second) * miss;
    }
    for (std::size_t i = 1; i < last; ++i)
      for (const BarEnd& bar : bars) push_out(bar, moved[i]);
  }
  return moved;
}

}  // namespace taut::mesh
