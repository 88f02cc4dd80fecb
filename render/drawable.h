// A mesh on the graphics side.
#pragma once

#include "render/connector_mesh.h"
#include "render/gpu.h"
#include "scenes/model/model.h"

namespace taut {

/// How a material's pattern is computed; the numbers are the surface shader's SURFACE.
enum class Surface { plain, wood, cloth, skin, rope, count };

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

  const Material& material() const { return material_; }
  Surface surface() const { return surface_; }
  /// The axis (0 x, 1 y, 2 z) along which the mesh is longest: wood's grain.
  int grain_axis() const { return grain_axis_; }

 private:
  const Gl* gl_;
  GlObject moving_, rest_, indices_, array_;
  GLsizei count_;
  Material material_;
  Surface surface_;
  int grain_axis_ = 1;
};

}  // namespace taut
