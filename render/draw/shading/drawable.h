// A mesh on the graphics side.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/gl/gpu.h"
#include "render/mesh/connector_mesh.h"
#include "scenes/model/model.h"

namespace taut::draw {

/// How a material's pattern is computed; the numbers are the surface shader's SURFACE.
enum class Surface { plain, wood, cloth, skin, rope, paper, turned, count };

/// The surface that a material's name asks for, such as "dark wood" or "skin".
Surface surface_named(std::string_view material);

class Drawable;

/// The constant part of a mesh: its triangles, as indices of vertices, and the pattern's inputs
/// (rest position, tint). And room for the vertices of a drawable of this shape.
class RestShape {
 public:
  RestShape(const gl::Gl& gl, std::vector<std::uint32_t> triangles,
            std::vector<mesh::RestVertex> rest);

  const std::vector<std::uint32_t>& triangles() const { return triangles_; }
  const std::vector<mesh::RestVertex>& rest() const { return rest_; }

 private:
  friend class Drawable;
  std::vector<std::uint32_t> triangles_;
  std::vector<mesh::RestVertex> rest_;
  gl::GlObject rest_buffer_, moving_, indices_, some_indices_;
  mutable const Drawable* loaded_ = nullptr;  // whose vertices moving_ has
  mutable std::vector<mesh::MovingVertex> vertices_;
  mutable std::size_t waiting_ = 0;  // indices drawn since the driver was told to draw
};

/// Triangles with one material, whose positions and normals may be replaced every frame. Drawables
/// of the same shape may share it if they follow something: the ropes of a curtain do.
class Drawable {
 public:
  Drawable(const gl::Gl& gl, std::shared_ptr<const RestShape> shape,
           const scenes::Material& material, Surface surface);
  /// A model's mesh in its bind pose; `texture` (or null) is that of its material.
  Drawable(const gl::Gl& gl, const scenes::Mesh& mesh, const scenes::Material& material,
           std::shared_ptr<const gl::GlObject> texture);

  /// For one that shares its shape with no other.
  void move(std::span<const mesh::MovingVertex> vertices);
  /// Vertices are asked for whenever they are drawn, until this is called again: to keep those of a
  /// thousand ropes would take more than all else.
  using Vertices = std::function<void(std::vector<mesh::MovingVertex>&)>;
  void follow(Vertices vertices);
  /// Indirect light (linear rgb, irradiance over pi) on each vertex, instead of the stage's.
  void bathe(std::span<const Eigen::Vector3f> light);
  bool bathed() const { return bool(light_); }
  void draw() const;
  /// Draws some of the triangles, given as indices of vertices.
  void draw(std::span<const std::uint32_t> indices);

  const std::vector<std::uint32_t>& triangles() const { return shape_->triangles(); }
  /// Where the vertices were last moved; none of one that follows.
  const std::vector<Eigen::Vector3f>& positions() const { return positions_; }
  /// Where the vertices are.
  void find_positions(std::vector<Eigen::Vector3f>& positions) const;
  /// Around them.
  const Eigen::AlignedBox3f& box() const { return box_; }

  /// GL's name of the picture that multiplies its colour; 0: none.
  GLuint texture() const { return texture_ ? texture_->id() : 0; }
  const scenes::Material& material() const { return material_; }
  Surface surface() const { return surface_; }
  /// The axis (0 x, 1 y, 2 z) along which the mesh is longest: wood's grain.
  int grain_axis() const { return grain_axis_; }
  /// How many times finer the grain is than that of a beam: small things are made of fine wood.
  float grain_scale() const { return grain_scale_; }
  /// Light that changes over 5 cm or more, as past the arms and past distant scenery, is as its
  /// vertices say: no triangle to speak of is longer.
  bool fine() const { return fine_; }
  /// How a rope's material moves past its vertices where winches change its length.
  struct Flow {
    float paid_out = 0;      // m, at its first end
    float length_ratio = 1;  // of its length to that with which it was made
  };
  const Flow& flow() const { return flow_; }
  void set_flow(const Flow& flow) { flow_ = flow; }

 private:
  void load() const;
  void make_arrays();
  gl::GlObject make_array(const gl::GlObject& indices) const;
  void draw(const gl::GlObject& array, std::size_t indices) const;

  const gl::Gl* gl_;
  std::shared_ptr<const RestShape> shape_;
  std::shared_ptr<const gl::GlObject> texture_;
  gl::GlObject light_, places_;  // on each vertex, and where each is on the texture
  gl::GlObject all_, some_;      // vertex arrays of all triangles, and of some
  Vertices follows_;
  std::vector<Eigen::Vector3f> positions_;
  Eigen::AlignedBox3f box_;
  scenes::Material material_;
  Surface surface_;
  int grain_axis_ = 1;
  float grain_scale_ = 1;
  bool fine_ = false;
  Flow flow_;
};

/// A picture as models have them, on the graphics side.
gl::GlObject make_picture_texture(const gl::Gl& gl, const scenes::Texture& texture);

/// Around all of them, in their own axes; empty without any.
Eigen::AlignedBox3d box_around(std::span<const Drawable> things);

// Something to draw, where.

/// Triangles of a drawable (indices of vertices), and the model matrix that they are drawn with.
struct DrawItem {
  Drawable* drawable;
  Eigen::Matrix4f model;
  std::span<const std::uint32_t> triangles;

  /// All of a drawable.
  DrawItem(Drawable& all, const Eigen::Matrix4f& place)
      : drawable(&all), model(place), triangles(all.triangles()) {}
  DrawItem(const DrawItem& of, std::span<const std::uint32_t> some)
      : drawable(of.drawable), model(of.model), triangles(some) {}

  void draw() const {
    if (triangles.size() == drawable->triangles().size()) return drawable->draw();
    drawable->draw(triangles);
  }
  /// Around the whole drawable.
  Eigen::AlignedBox3f box() const { return drawable->box().transformed(Eigen::Affine3f(model)); }
};

}  // namespace taut::draw
