// A mesh on the graphics side.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "render/connector_mesh.h"
#include "render/gpu.h"
#include "scenes/model/model.h"

namespace taut {

/// How a material's pattern is computed; the numbers are the surface shader's SURFACE.
enum class Surface { plain, wood, cloth, skin, rope, paper, count };

/// The surface that a material's name asks for, such as "dark wood" or "skin".
Surface surface_named(std::string_view material);

/// Triangles with one material. Positions and normals may be replaced every frame; what the
/// pattern hangs on (rest position, tint) stays.
class Drawable {
 public:
  Drawable(const Gl& gl, std::span<const std::uint32_t> indices, std::span<const RestVertex> rest,
           const Material& material, Surface surface);
  /// A model's mesh in its bind pose.
  Drawable(const Gl& gl, const Mesh& mesh, const Material& material);

  void move(std::span<const MovingVertex> vertices);
  void draw() const;
  /// Draws some of the triangles, given as indices of vertices.
  void draw(std::span<const std::uint32_t> indices);

  const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  /// Where the vertices were last moved.
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }
  /// Around them.
  const Eigen::AlignedBox3f& box() const { return box_; }

  const Material& material() const { return material_; }
  Surface surface() const { return surface_; }
  /// The axis (0 x, 1 y, 2 z) along which the mesh is longest: wood's grain.
  int grain_axis() const { return grain_axis_; }
  /// How many times finer the grain is than that of a beam: small things are made of fine wood.
  float grain_scale() const { return grain_scale_; }

 private:
  const Gl* gl_;
  GlObject moving_, rest_, indices_, some_indices_, array_;
  std::vector<std::uint32_t> triangles_;
  std::vector<Eigen::Vector3f> positions_;
  Eigen::AlignedBox3f box_;
  Material material_;
  Surface surface_;
  int grain_axis_ = 1;
  float grain_scale_ = 1;
};

}  // namespace taut
