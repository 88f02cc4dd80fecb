#include "render/draw/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/draw/contact.h"
#include "render/draw/lighting.h"
#include "render/draw/noise.h"
#include "render/gl/shaders.h"

namespace taut {
namespace {

constexpr double kExposure = 0.48;

}  // namespace

FrameBlock::FrameBlock(const CameraView& camera, const Rect& viewport)
    : view_projection(camera_projection(camera, double(viewport.width) / viewport.height)),
      light_projection(Eigen::Matrix4f::Zero()) {
  eye << camera.position.cast<float>(), 0;
  capsule_from.fill(Eigen::Vector4f::Zero());
  capsule_to.fill(Eigen::Vector4f::Zero());
}

Surfaces::Surfaces(const Gl& gl, const Light& light, int shadow_map_size, bool lit)
    : gl_(gl),
      frame_(make_buffer(gl)),
      noise_(make_noise_texture(gl)),
      constants_(fmt::format(
          "#define LIT {:d}\n#define EXPOSURE {}\n#define SHADOW_SIZE {}.0\n#define CONTACT_REACH "
          "{:.1f}\n{}{}",
          lit, kExposure, shadow_map_size, kContactReach, light_constants(light),
          shaders::frame_block)) {}

const Program& Surfaces::program(Surface surface, Shade shade) {
  auto& slot = programs_[{surface, shade}];
  if (!slot)
    slot = std::make_unique<Program>(gl_,
                                     fmt::format("#define SURFACE {}\n#define SHADE {}\n{}",
                                                 int(surface), int(shade), constants_),
                                     shaders::surface_vertex, shaders::surface_fragment);
  return *slot;
}

void Surfaces::use(const FrameBlock& block) const {
  upload(gl_, frame_, std::span<const FrameBlock>(&block, 1), GL_DYNAMIC_DRAW);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, 0, frame_.id());
  gl_.BindTextureUnit(1, noise_.id());
}

void Surfaces::draw(const DrawItem& item, Shade shade, float opacity) {
  if (item.triangles.empty()) return;
  const Program& p = program(item.drawable->surface(), shade);
  const Material& material = item.drawable->material();
  p.use();
  p.set("model", item.model);
  p.set("base_color", Eigen::Vector3f(material.base_color.data()));
  p.set("base_roughness", std::max(material.roughness, 0.08f));
  p.set("metallic", material.metallic);
  p.set("opacity", opacity);
  p.set("grain_axis", item.drawable->grain_axis());
  p.set("grain_scale", item.drawable->grain_scale());
  item.draw();
}

}  // namespace taut
