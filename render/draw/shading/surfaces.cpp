#include "render/draw/shading/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/draw/shading/contact.h"
#include "render/draw/shading/lighting.h"
#include "render/draw/shading/noise.h"
#include "render/gl/shaders.h"

namespace taut::draw {
namespace {

constexpr double kExposure = 0.44;
constexpr float kGlossy = 0.45f;  // rougher surfaces mirror what lights them

std::string mirror_constants(const Surroundings& around) {
  std::string constants = fmt::format("#define MIRROR {:d}\n", around.mirror != 0);
  if (!around.mirror) return constants;
  for (const auto& [name, value] : {std::pair("ROOM_LOW", around.room.min()),
                                    {"ROOM_HIGH", around.room.max()},
                                    {"MIDDLE", around.middle}})
    constants += fmt::format("const vec3 {} = vec3({:.9g}, {:.9g}, {:.9g});\n", name, value.x(),
                             value.y(), value.z());
  return constants + fmt::format("#define ROUGHEST {}.0\n", around.levels - 1);
}

/// The same shade by one look-up, without layers.
Shade looked_up(Shade shade) {
  if (shade == Shade::swept) return Shade::averaged;
  return shade == Shade::grounded_swept ? Shade::grounded : shade;
}

}  // namespace

FrameBlock::FrameBlock(const scenes::CameraView& camera, const picture::Rect& viewport)
    : view_projection(camera_projection(camera, double(viewport.width) / viewport.height)),
      light_projection(Eigen::Matrix4f::Zero()) {
  eye << camera.position.cast<float>(), 0;
  capsule_from.fill(Eigen::Vector4f::Zero());
  capsule_to.fill(Eigen::Vector4f::Zero());
  moved_light.fill(Eigen::Vector4f::Zero());
}

Surfaces::Surfaces(const gl::Gl& gl, const scenes::Light& light, const Surroundings& around,
                   const SceneryShadow& scenery, int shadow_map_size, Output output,
                   const CapsuleCounts& capsules)
    : gl_(gl),
      frame_(gl::make_buffer(gl)),
      noise_(make_noise_texture(gl)),
      mirror_(around.mirror),
      scenery_(scenery),
      constants_(fmt::format(
          "#define OUTPUT {}\n#define EXPOSURE {}\n#define SHADOW_SIZE {}.0\n#define "
          "LEAST_PENUMBRA (1.5 / SHADOW_SIZE)\n#define CONTACT_RANGE {:.1f}\n#define FEET {}\n"
          "#define LEGS {}\n#define CAPSULES {}\n{}{}{}{}{}",
          int(output), kExposure, shadow_map_size, kContactRange, capsules.feet, capsules.legs,
          capsules.all, light_constants(light, around.ambient), mirror_constants(around),
          scenery.constants(), gl::shaders::frame_block, gl::shaders::contact)) {}

const gl::Program& Surfaces::program(const Variant& v) {
  auto& slot = programs_[v];
  if (!slot)
    slot = std::make_unique<gl::Program>(
        gl_,
        fmt::format("#define SURFACE {}\n#define SHADE {}\n#define LAYERED {:d}\n#define GLOSSY "
                    "{:d}\n#define BATHED "
                    "{:d}\n#define FINE {:d}\n#define TEXTURED {:d}\n{}",
                    int(v.surface), int(looked_up(v.shade)), looked_up(v.shade) != v.shade,
                    v.glossy, v.bathed, v.fine, v.textured, constants_),
        gl::shaders::surface_vertex, gl::shaders::surface_fragment);
  return *slot;
}

void Surfaces::use(const FrameBlock& block) const {
  gl::upload(gl_, frame_, std::span<const FrameBlock>(&block, 1), GL_DYNAMIC_DRAW);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, 0, frame_.id());
  gl_.BindTextureUnit(1, noise_.id());
  if (mirror_) gl_.BindTextureUnit(2, mirror_);
  scenery_.bind();
}

void Surfaces::draw(const DrawItem& item, Shade shade, float opacity) {
  if (item.triangles.empty()) return;
  const scenes::Material& material = item.drawable->material();
  const bool bathed = item.drawable->bathed();
  const gl::Program& p =
      program({item.drawable->surface(), shade, material.roughness < kGlossy, bathed,
               !bathed && item.drawable->fine(), item.drawable->texture() != 0});
  p.use();
  if (item.drawable->texture()) gl_.BindTextureUnit(7, item.drawable->texture());
  p.set("model", item.model);
  p.set("base_color", Eigen::Vector3f(material.base_color.data()));
  p.set("base_roughness", std::max(material.roughness, 0.08f));
  p.set("metallic", material.metallic);
  p.set("opacity", opacity);
  p.set("grain_axis", item.drawable->grain_axis());
  p.set("grain_scale", item.drawable->grain_scale());
  p.set("paid_out", item.drawable->flow().paid_out);
  p.set("length_ratio", item.drawable->flow().length_ratio);
  item.draw();
}

}  // namespace taut::draw
