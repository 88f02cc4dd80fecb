// Models of plain solids, for bodies that name no mesh.
#pragma once

#include <cstdint>

#include "scenes/model/model.h"
#include "sim/motion/types.h"

namespace taut::scenes {

// Centred on the origin; sizes in m; `color` linear.
Model cylinder_model(double length, double diameter, const Vec3& color);  // axis along y
Model sphere_model(double diameter, const Vec3& color);
Model box_model(const Vec3& size, const Vec3& color);

/// The vertex, as floats, at the end of the mesh; its index.
std::uint32_t add_vertex(Mesh& mesh, const Vec3& position, const Vec3& normal);
/// A four-sided face; a, b, c, d run counter-clockwise seen from outside.
void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

}  // namespace taut::scenes
