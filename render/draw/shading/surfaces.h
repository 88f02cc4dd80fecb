// Lit surfaces: their shaders, what these need to know of a frame, and contact shadows.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <compare>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/draw/shading/drawable.h"
#include "render/draw/shading/lighting.h"
#include "render/draw/shading/shadow_map.h"
#include "render/gl/gpu.h"
#include "render/picture/picture.h"
#include "scenes/character/capsules.h"
#include "scenes/scene/stage.h"
#include "sim/motion/types.h"

namespace taut::draw {

// The texture that wood, cloth and skin take their irregularity from.

/// Two channels of tiling fractal noise around 1/2, and the slopes of creases along both axes,
/// which lie where the first is 1/2: by 510 ths, over four texels, from 128 of 255. With mipmaps,
/// repeating beyond its edge.
gl::GlObject make_noise_texture(const gl::Gl& gl);

constexpr std::size_t kCapsules = 12;
/// Most instants of what moves whose shadows a surface shows at once.
constexpr std::size_t kLayers = 8;

/// The uniforms of a frame for every surface; mirrors the shaders' block.
struct FrameBlock {
  Eigen::Matrix4f view_projection, light_projection;
  Eigen::Vector4f eye;  // w: offset along the normal before the shadow's look-up, m
  std::array<Eigen::Vector4f, kCapsules> capsule_from, capsule_to;
  float penumbra = 0;     // half of it, in widths of the map, for each of its depths
  float texel_depth = 0;  // a texel's width, in depths of the map
  float pivot = 0;        // the depth at which moving the light moves no shadow
  int first_layer = 0, end_layer = 0;
  std::array<float, 3> unused{};
  std::array<Eigen::Vector4f, kLayers>
      moved_light;  // xy: of each layer, for a depth past the pivot
  Eigen::Vector4f layered = Eigen::Vector4f::Zero();
  Eigen::Vector4f on_layers = Eigen::Vector4f::Zero();

  /// Without anything that moves.
  FrameBlock(const scenes::CameraView& camera, const picture::Rect& viewport);
};

/// How many capsules there are.
struct CapsuleCounts {
  int feet = 0;  // the first ones, which darken the scenery
  int legs = 0;  // these and the shins, which it mirrors
  int all = 0;   // the others darken what moves
};

/// The occluders of a surface's light; the numbers are the surface shader's SHADE.
enum class Shade {
  lit,       // nothing
  shadowed,  // the shadow map, and capsules of bodies
  grounded,  // the same with those of feet; the share of it that is left of the backdrop's light
  averaged,  // the shadow map less smoothly, for one of many exposures in different lights
  swept,     // the mean of several such look-ups, in the layers of the shadow map
  grounded_swept,  // as grounded, the mean of the shadow map's layers
};

/// The surroundings of the things of a stage, besides the key light.
struct Surroundings {
  Harmonics ambient;           // on things without light of their own
  GLuint mirror = 0;           // a cube texture, blurred more from level to level; 0: none
  int levels = 0;              // of it, of roughness from 0 to 1
  Eigen::AlignedBox3d room{};  // the walls that are mirrored
  Vec3 middle = Vec3::Zero();  // where the cube was seen from
};

/// The output for a surface; the numbers are the surface shader's OUTPUT.
enum class Output {
  flat,      // one colour everywhere
  display,   // the root of tone-mapped light
  radiance,  // linear light
};

class Surfaces {
 public:
  /// `scenery` must outlive it.
  Surfaces(const gl::Gl& gl, const scenes::Light& light, const Surroundings& surroundings,
           const SceneryShadow& scenery, int shadow_map_size, Output output,
           const CapsuleCounts& capsules = {});

  /// Sets the camera and light of the following draws.
  void use(const FrameBlock& block) const;
  void draw(const DrawItem& item, Shade shade, float opacity = 1);

 private:
  /// What a surface's shader is compiled for.
  struct Variant {
    Surface surface;
    Shade shade;
    bool glossy;  // it mirrors the room
    bool bathed;  // it has light of its own on each vertex
    bool fine;    // light that changes slowly is found at its vertices
    bool textured;
    auto operator<=>(const Variant&) const = default;
  };
  const gl::Program& program(const Variant& variant);

  const gl::Gl& gl_;
  gl::GlObject frame_, noise_;
  GLuint mirror_;
  const SceneryShadow& scenery_;
  std::string constants_;
  std::map<Variant, std::unique_ptr<gl::Program>> programs_;
};

// Contact shadows: what is near a surface takes ambient light from it, as feet from the floor.

/// How far a capsule's contact shadow reaches from its axis, in radii.
constexpr double kContactRange = 6;

struct ContactCapsule {
  Vec3 from, to;  // m, the ends of its axis
  double radius;  // m

  /// Around everything that it darkens.
  Eigen::AlignedBox3f bounds() const;
};

/// The feet of a character whose bones have these poses: its soles, and its toes.
std::vector<ContactCapsule> feet(const scenes::Model& character, const std::vector<Pose>& bones);

/// The shins of a character whose bones have these poses.
std::vector<ContactCapsule> shins(const scenes::Model& character, const std::vector<Pose>& bones);

/// The arms of a character in its bind pose, which darken its trunk (scenes::place_capsules).
std::vector<scenes::Capsule> arms(const scenes::Model& character);

/// A body's model along its longest side, in the body's frame; none where it is not twice as long
/// as it is wide.
std::optional<ContactCapsule> rod(const scenes::Model& model);

}  // namespace taut::draw
