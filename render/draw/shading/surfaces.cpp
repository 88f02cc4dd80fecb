#include "render/draw/shading/surfaces.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/draw/shading/lighting.h"
#include "render/gl/shaders.h"

namespace taut::draw {
namespace {

/// An even hash of a lattice point, 0 to 1.
float hashed(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return float((h ^ (h >> 15)) >> 8) / float(1u << 24);
}

float smooth(float t) {
  return t * t * (3 - 2 * t);
}

/// Value noise that repeats after `period` cells.
class ValueNoise {
 public:
  ValueNoise(std::uint32_t period, std::uint32_t seed) : period_(period) {
    for (std::uint32_t y = 0; y < period; ++y)
      for (std::uint32_t x = 0; x < period; ++x) lattice_.push_back(hashed(x, y, seed));
  }

  /// For places in the first period, in cells.
  float at(float x, float y) const {
    const auto x0 = std::uint32_t(x), y0 = std::uint32_t(y);
    const float u = smooth(x - float(x0)), v = smooth(y - float(y0));
    const std::uint32_t x1 = x0 + 1 < period_ ? x0 + 1 : 0, y1 = y0 + 1 < period_ ? y0 + 1 : 0;
    const float *row = &lattice_[y0 * period_], *next = &lattice_[y1 * period_];
    return between(between(row[x0], row[x1], u), between(next[x0], next[x1], u), v);
  }

 private:
  static float between(float a, float b, float t) { return a + t * (b - a); }

  std::uint32_t period_;
  std::vector<float> lattice_;
};

}  // namespace

gl::GlObject make_noise_texture(const gl::Gl& gl) {
  constexpr int kSize = 256, kLevels = 9, kOctaves = 4, kChannels = 4;
  std::vector<std::uint8_t> pixels(kChannels * kSize * kSize);
  const auto channels = [&](int x, int y) {
    return &pixels[kChannels * std::size_t(y % kSize * kSize + x % kSize)];
  };
  for (std::uint32_t channel = 0; channel < 2; ++channel) {
    std::vector<ValueNoise> octaves;
    std::vector<float> scales;                // cells of a pixel
    std::uint32_t period = channel ? 32 : 8;  // the second channel starts at finer cells
    for (std::uint32_t octave = 0; octave < kOctaves; ++octave) {
      octaves.emplace_back(period, 8 * channel + octave);
      scales.push_back(float(period) / kSize);
      period = std::min(2 * period, std::uint32_t(kSize));
    }
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        float sum = 0, amplitude = 0.5f;
        for (std::size_t i = 0; i < kOctaves; ++i) {
          sum += amplitude * octaves[i].at(float(x) * scales[i], float(y) * scales[i]);
          amplitude *= 0.5f;
        }
        channels(x, y)[channel] = std::uint8_t(std::lround(255 * sum / (1 - amplitude * 2)));
      }
  }
  // Creases are where the first channel is 1/2. Their slope is the difference over four texels: its
  // 8 bits show in one.
  constexpr int kOver = 4, kNoRise = 128;
  const auto height = [&](int x, int y) { return -std::abs(2 * int(channels(x, y)[0]) - 255); };
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int here = height(x, y);
      const auto rise = [&](int there) {
        return std::uint8_t(std::clamp(kNoRise + there - here, 0, 255));
      };
      channels(x, y)[2] = rise(height(x + kOver, y));
      channels(x, y)[3] = rise(height(x, y + kOver));
    }
  gl::GlObject texture = gl::make_texture(gl, GL_RGBA8, kSize, kSize, 0, kLevels);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TextureSubImage2D(texture.id(), 0, 0, 0, kSize, kSize, GL_RGBA, GL_UNSIGNED_BYTE,
                       pixels.data());
  gl.GenerateTextureMipmap(texture.id());
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl.TextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
  return texture;
}

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

Eigen::AlignedBox3f ContactCapsule::bounds() const {
  const Vec3 far = Vec3::Constant(kContactRange * radius);
  return Eigen::AlignedBox3d(from.cwiseMin(to) - far, from.cwiseMax(to) + far).cast<float>();
}

namespace {

/// Where a foot points on the floor in the bind pose, in the frame of its toes' bone.
Vec3 toes_ahead(const scenes::Model& character, std::size_t toes) {
  const auto bind = [&](std::size_t bone) {
    return character.bones[bone].inverse_bind.cast<double>().eval();
  };
  const auto place = [&](std::size_t bone) {
    return Vec3(bind(bone).inverse().topRightCorner<3, 1>());
  };
  Vec3 ahead = place(toes) - place(std::size_t(character.bones[toes].parent));
  ahead.y() = 0;
  return bind(toes).topLeftCorner<3, 3>() * ahead.normalized();
}

}  // namespace

std::vector<ContactCapsule> feet(const scenes::Model& character, const std::vector<Pose>& bones) {
  constexpr double kFoot = 0.055, kToes = 0.016, kToe = 0.06;  // m: radii, and toes' length
  std::vector<ContactCapsule> capsules;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const scenes::Bone& bone = character.bones[i];
    if (bone.parent < 0 || !bone.name.ends_with("ToeBase")) continue;
    const Vec3 ankle = bones[std::size_t(bone.parent)].position, ball = bones[i].position;
    const Vec3 ahead = bones[i].rotation * toes_ahead(character, i);
    capsules.push_back({ankle, ball, kFoot});
    capsules.push_back({ball, ball + kToe * ahead, kToes});
  }
  return capsules;
}

std::vector<ContactCapsule> shins(const scenes::Model& character, const std::vector<Pose>& bones) {
  constexpr double kShin = 0.06;  // m
  std::vector<ContactCapsule> capsules;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const int ankle = character.bones[i].parent;
    if (ankle < 0 || !character.bones[i].name.ends_with("ToeBase")) continue;
    const int knee = character.bones[std::size_t(ankle)].parent;
    if (knee < 0) continue;
    capsules.push_back(
        {bones[std::size_t(knee)].position, bones[std::size_t(ankle)].position, kShin});
  }
  return capsules;
}

std::vector<scenes::Capsule> arms(const scenes::Model& character) {
  std::vector<scenes::Capsule> capsules = scenes::fit_capsules(character);
  std::erase_if(capsules, [&](const scenes::Capsule& c) {
    return !character.bones[c.bone].name.ends_with("Arm");
  });
  return capsules;
}

std::optional<ContactCapsule> rod(const scenes::Model& model) {
  Eigen::AlignedBox3d box;
  for (const scenes::Mesh& mesh : model.meshes)
    for (const scenes::Vertex& v : mesh.vertices)
      box.extend(Eigen::Vector3f(v.position.data()).cast<double>());
  if (box.isEmpty()) return {};
  int axis = 0;
  const double length = box.sizes().maxCoeff(&axis);
  Vec3 across = box.sizes();
  across[axis] = 0;
  const double radius = across.maxCoeff() / 2;
  if (length < 4 * radius) return {};
  const Vec3 half = (length / 2 - radius) * Vec3::Unit(axis);
  return ContactCapsule{box.center() - half, box.center() + half, radius};
}

}  // namespace taut::draw
