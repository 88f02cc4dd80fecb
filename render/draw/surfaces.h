// Lit surfaces: their shaders, and what these need to know of a frame.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>

#include "render/draw/draw_item.h"
#include "render/gl/gpu.h"
#include "render/picture/rect.h"
#include "scenes/scene/stage.h"

namespace taut {

constexpr std::size_t kCapsules = 6;

/// What every surface needs to know of a frame; mirrors the shaders' block.
struct FrameBlock {
  Eigen::Matrix4f view_projection, light_projection;
  Eigen::Vector4f eye;  // w: offset along the normal before the shadow's look-up, m
  std::array<Eigen::Vector4f, kCapsules> capsule_from, capsule_to;
  std::array<int, 4> capsules{};  // how many; the rest is padding

  /// Without anything that moves.
  FrameBlock(const CameraView& camera, const Rect& viewport);
};

/// What takes light from a surface; the numbers are the surface shader's SHADE.
enum class Shade {
  lit,       // nothing
  shadowed,  // the shadow map
  grounded,  // capsules as well
  averaged,  // the shadow map less smoothly, for one of many exposures in different lights
};

class Surfaces {
 public:
  /// `lit` false: all have one colour.
  Surfaces(const Gl& gl, const Light& light, int shadow_map_size, bool lit);

  /// What is drawn from now on is seen and lit like this.
  void use(const FrameBlock& block) const;
  void draw(const DrawItem& item, Shade shade, float opacity = 1);

 private:
  const Program& program(Surface surface, Shade shade);

  const Gl& gl_;
  GlObject frame_, noise_;
  std::string constants_;
  std::map<std::pair<Surface, Shade>, std::unique_ptr<Program>> programs_;
};

}  // namespace taut
