#include "render/mesh/pieces.h"

#include <algorithm>

namespace taut::mesh {
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

}  // namespace taut::mesh
