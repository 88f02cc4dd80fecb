// Hard geometry that is drawn many times: wires bent to closed curves, bodies of revolution.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "render/mesh/moving_mesh.h"

namespace taut::mesh {

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

}  // namespace taut::mesh
