// Something to draw, where.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>

#include "render/draw/shading/drawable.h"

namespace taut::draw {

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
