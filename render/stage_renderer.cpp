#include "render/stage_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/contact.h"
#include "render/drawable.h"
#include "render/lighting.h"
#include "render/noise.h"
#include "render/reach.h"
#include "render/shaders.h"
#include "render/shadow_cover.h"
#include "render/skinning.h"
#include "sim/hash.h"

namespace taut {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr std::size_t kCapsules = 6;
constexpr float kShadowFilter = 5;  // texels: half the filter, and the offset along the normal
constexpr double kExposure = 0.38;

/// What every surface needs to know of a frame; mirrors the shaders' block.
struct FrameBlock {
  Matrix4f view_projection, light_projection;
  Vector4f eye;
  std::array<Vector4f, kCapsules> capsule_from, capsule_to;
  std::array<int, 4> capsules{};  // how many; the rest is padding
};

/// A radiance as the canvas keeps it; the surface shader's encode().
double encoded(double radiance) {
  const double x = radiance * kExposure;
  return std::sqrt(std::min(x * (2 * x + 0.05) / (x * (1.95 * x + 0.75) + 0.12), 1.0));
}

Vector4f with_w(const Vec3& v, double w) {
  return {float(v.x()), float(v.y()), float(v.z()), float(w)};
}

Matrix4f matrix(const Pose& pose) {
  Matrix4f m = Matrix4f::Identity();
  m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix().cast<float>();
  m.topRightCorner<3, 1>() = pose.position.cast<float>();
  return m;
}

std::vector<Drawable> drawables(const Gl& gl, const Model& model) {
  std::vector<Drawable> result;
  for (const Mesh& mesh : model.meshes)
    result.emplace_back(gl, mesh, model.materials[mesh.material]);
  return result;
}

/// One thing to draw, where.
struct Item {
  const Drawable* drawable;
  Matrix4f model;

  Eigen::AlignedBox3f box() const { return drawable->box().transformed(Eigen::Affine3f(model)); }
};

/// What takes light from a surface; the numbers are the surface shader's SHADE.
enum class Shade { lit, shadowed, grounded };  // nothing; the shadow map; capsules as well

}  // namespace

struct StageRenderer::Impl {
  Impl(const Context& context, const Stage& s, const World& world, const Shadows& options)
      : gl(context.gl()),
        stage(s),
        shadows(options),
        frame(make_buffer(gl)),
        shadow_map(make_texture(gl, GL_DEPTH_COMPONENT24, shadows.map_size, shadows.map_size)),
        shadow_target(make_framebuffer(gl, 0, shadow_map.id())),
        noise(make_noise_texture(gl)),
        depth_program(gl, shaders::frame_block, shaders::depth_vertex, shaders::depth_fragment),
        constants(fmt::format(
            "#define EXPOSURE {}\n#define SHADOW_SIZE {}.0\n#define CONTACT_REACH {:.1f}\n{}{}",
            kExposure, shadows.map_size, kContactReach, light_constants(s.light),
            shaders::frame_block)) {
    const GLuint map = shadow_map.id();
    gl.TextureParameteri(map, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.TextureParameteri(map, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);

    for (const auto& model : stage.scenery)
      for (Drawable& part : drawables(gl, *model)) scenery.push_back(std::move(part));
    shadowed.resize(scenery.size());
    for (const auto& model : stage.body_models)
      bodies.push_back(model ? drawables(gl, *model) : std::vector<Drawable>());
    for (const auto& model : stage.characters) characters.push_back(drawables(gl, *model));
    for (std::size_t i = 0; i < world.connectors.size(); ++i) {
      const ConnectorLook look =
          i < stage.connector_looks.size() ? stage.connector_looks[i] : ConnectorLook();
      connector_meshes.push_back(make_connector_mesh(world.connectors[i], look));
      const bool chain = look.kind == ConnectorLook::Kind::chain;
      const Material material{.name = chain ? "steel" : "rope",
                              .base_color = {1, 1, 1},
                              .roughness = chain ? 0.35f : 0.9f,
                              .metallic = chain ? 1.0f : 0.0f};
      connectors.emplace_back(gl, connector_meshes[i]->indices(), connector_meshes[i]->rest(),
                              material, chain ? Surface::plain : Surface::rope);
    }
  }

  const Program& program(Surface surface, Shade shade) {
    auto& slot = programs[{surface, shade}];
    if (!slot)
      slot = std::make_unique<Program>(gl,
                                       fmt::format("#define SURFACE {}\n#define SHADE {}\n{}",
                                                   int(surface), int(shade), constants),
                                       shaders::surface_vertex, shaders::surface_fragment);
    return *slot;
  }

  void pose(const Instant& instant) {
    for (std::size_t i = 0; i < std::min(characters.size(), instant.bones.size()); ++i) {
      const Model& model = *stage.characters[i];
      const std::vector<BoneMatrix> bones = bone_matrices(model, instant.bones[i]);
      for (std::size_t k = 0; k < model.meshes.size(); ++k) {
        skin(model.meshes[k], bones, vertices);
        characters[i][k].move(vertices);
      }
    }
    for (std::size_t i = 0; i < connectors.size(); ++i) {
      connector_meshes[i]->place(instant.state.connectors[i], instant.state.bodies, vertices);
      connectors[i].move(vertices);
    }
  }

  /// Things in front of the scenery, as far as the layer shows them.
  std::vector<Item> moving_items(const Instant& instant, const Layer& layer) const {
    std::vector<Item> items;
    if (layer.characters)
      for (const auto& character : characters)
        for (const Drawable& part : character) items.push_back({&part, Matrix4f::Identity()});
    if (layer.bodies)
      for (std::size_t i = 0; i < bodies.size(); ++i)
        for (const Drawable& part : bodies[i])
          items.push_back({&part, matrix(instant.state.bodies[i])});
    if (layer.connectors)
      for (const Drawable& connector : connectors)
        items.push_back({&connector, Matrix4f::Identity()});
    return items;
  }

  static Eigen::AlignedBox3d casters(const Instant& instant) {
    Eigen::AlignedBox3d box;
    for (const auto& particles : instant.state.connectors)
      for (const Vec3& p : particles) box.extend(p);
    for (const Pose& body : instant.state.bodies) box.extend(body.position);
    for (const auto& bones : instant.bones)
      for (const Pose& bone : bones) box.extend(bone.position);
    if (box.isEmpty()) box.extend(Vec3::Zero());
    const Vec3 margin = Vec3::Constant(0.35);  // flesh around bones, sticks beyond their middles
    return {box.min() - margin, box.max() + margin};
  }

  /// The block's capsules, and what they can reach.
  std::vector<Eigen::AlignedBox3f> add_contacts(const Instant& instant, FrameBlock& block) const {
    std::vector<Eigen::AlignedBox3f> reach;
    if (!shadows.contact) return reach;
    for (std::size_t c = 0; c < std::min(instant.bones.size(), stage.characters.size()); ++c)
      for (const Capsule& capsule : feet(*stage.characters[c], instant.bones[c])) {
        if (reach.size() == kCapsules) break;
        const Vec3 axis = capsule.to - capsule.from;
        block.capsule_from[reach.size()] = with_w(capsule.from, capsule.radius);
        block.capsule_to[reach.size()] = with_w(capsule.to, 1 / std::max(axis.squaredNorm(), 1e-6));
        reach.push_back(capsule.reach());
      }
    block.capsules[0] = int(reach.size());
    return reach;
  }

  /// The block of a frame without anything that moves.
  FrameBlock scenery_block(const CameraView& camera, const Rect& viewport) const {
    FrameBlock block;
    block.view_projection = camera_projection(camera, double(viewport.width) / viewport.height);
    block.light_projection.setZero();
    block.eye = with_w(camera.position, 0);
    block.capsule_from.fill(Vector4f::Zero());
    block.capsule_to.fill(Vector4f::Zero());
    return block;
  }

  void use(const FrameBlock& block) const {
    upload(gl, frame, std::span<const FrameBlock>(&block, 1), GL_DYNAMIC_DRAW);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, frame.id());
  }

  void draw_solid() const {
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthMask(GL_TRUE);
    gl.DepthFunc(GL_LESS);
    gl.Enable(GL_CULL_FACE);
    gl.CullFace(GL_BACK);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_SCISSOR_TEST);
  }

  void draw_shadow_map(std::span<const Item> casters) const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_target.id());
    gl.Viewport(0, 0, shadows.map_size, shadows.map_size);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    // A lit rim stays, which stands for everything beyond the map.
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(2, 2, shadows.map_size - 4, shadows.map_size - 4);
    gl.Enable(GL_DEPTH_CLAMP);
    gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(1.5f, 2.0f);
    draw_depth(casters);
    gl.Disable(GL_POLYGON_OFFSET_FILL);
    gl.Disable(GL_DEPTH_CLAMP);
    gl.Disable(GL_SCISSOR_TEST);
  }

  void draw_depth(std::span<const Item> items) const {
    depth_program.use();
    for (const Item& item : items) {
      depth_program.set("model", item.model);
      item.drawable->draw();
    }
  }

  void use_surface(const Drawable& drawable, const Matrix4f& model, Shade shade, float opacity) {
    const Program& p = program(drawable.surface(), shade);
    const Material& material = drawable.material();
    p.use();
    p.set("model", model);
    p.set("base_color", Vector3f(material.base_color.data()));
    p.set("base_roughness", std::max(material.roughness, 0.08f));
    p.set("metallic", material.metallic);
    p.set("opacity", opacity);
    p.set("grain_axis", drawable.grain_axis());
  }

  /// The scenery once more, where shadows of moving things reach it and it still is in front. Tells
  /// which pixels that can be.
  Rect draw_shadows(std::span<const Item> moving, std::span<const Eigen::AlignedBox3f> contacts,
                    const FrameBlock& block, const Rect& viewport) {
    cover.start(block.light_projection, kShadowFilter / float(shadows.map_size));
    for (const auto& [drawable, model] : moving) cover.add(*drawable, model);
    Eigen::AlignedBox3f receivers;
    for (std::size_t i = 0; i < scenery.size(); ++i)
      receivers.extend(cover.find(scenery[i], contacts, shadowed[i]));

    Reach reach;
    const Vector3f direction = stage.light.direction.cast<float>();
    for (const Item& item : moving) add_shadow(item.box(), direction, receivers, reach);
    for (const Eigen::AlignedBox3f& box : contacts) add_box(box.intersection(receivers), reach);
    const Rect part = pixels(reach, block.view_projection, viewport);
    if (part.empty()) return part;

    gl.DepthFunc(GL_LEQUAL);
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(part.x, part.y, part.width, part.height);
    for (std::size_t i = 0; i < scenery.size(); ++i) {
      if (shadowed[i].empty()) continue;
      use_surface(scenery[i], Matrix4f::Identity(), Shade::grounded, 1);
      scenery[i].draw(shadowed[i]);
    }
    gl.Disable(GL_SCISSOR_TEST);
    return part;
  }

  void lap(const char* name) const {
    if (!profile) return;
    gl.Finish();
    profile->lap(name);
  }

  const Gl& gl;
  const Stage& stage;
  const Shadows shadows;
  Profile* profile = nullptr;
  GlObject frame, shadow_map, shadow_target, noise;
  Program depth_program;
  std::string constants;  // of the surface shaders
  std::map<std::pair<Surface, Shade>, std::unique_ptr<Program>> programs;
  std::vector<Drawable> scenery;
  std::vector<std::vector<Drawable>> bodies, characters;
  std::vector<std::unique_ptr<ConnectorMesh>> connector_meshes;
  std::vector<Drawable> connectors;
  ShadowCover cover;
  std::vector<MovingVertex> vertices;
  std::vector<std::vector<std::uint32_t>> shadowed;  // [scenery], indices of vertices
};

StageRenderer::StageRenderer(const Context& context, const Stage& stage, const World& world,
                             const Shadows& shadows)
    : impl_(std::make_unique<Impl>(context, stage, world, shadows)) {}

StageRenderer::~StageRenderer() = default;

void StageRenderer::set_profile(Profile* profile) {
  impl_->profile = profile;
}

void StageRenderer::begin(Canvas& canvas, std::span<const View> views) {
  Impl& d = *impl_;
  const Gl& gl = d.gl;
  Hash name;
  for (const auto& [viewport, camera] : views) {
    for (const int pixels : {viewport.x, viewport.y, viewport.width, viewport.height})
      name.number(pixels);
    for (int k = 0; k < 3; ++k) name.number(camera.position[k]).number(camera.target[k]);
    name.number(camera.field_of_view);
  }
  if (canvas.restore(name.value())) return d.lap("backdrop");

  d.draw_solid();
  canvas.bind();
  const Vec3 c = d.stage.background.unaryExpr(&encoded);
  gl.ClearColor(float(c.x()), float(c.y()), float(c.z()), 1);
  gl.DepthFunc(GL_LEQUAL);  // where faces coincide, the last is in front: with its shadows, too
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl.BindTextureUnit(1, d.noise.id());
  for (const auto& [viewport, camera] : views) {
    d.use(d.scenery_block(camera, viewport));
    gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
    for (const Drawable& part : d.scenery) {
      d.use_surface(part, Matrix4f::Identity(), Shade::lit, 1);
      part.draw();
    }
  }
  canvas.keep(name.value());
  d.lap("scenery");
}

void StageRenderer::draw(Canvas& canvas, const Rect& viewport, const Instant& instant,
                         const Layer& layer) {
  Impl& d = *impl_;
  const Gl& gl = d.gl;
  d.pose(instant);
  d.lap("skin");
  const std::vector<Item> moving = d.moving_items(instant, layer);
  const bool solid = layer.opacity >= 1;

  const Light& light = d.stage.light;
  const LightMap map = light_map(light.direction, Impl::casters(instant), d.shadows.map_size);
  FrameBlock block = d.scenery_block(instant.camera, viewport);
  block.light_projection = map.projection;
  block.eye.w() = float(1.5 * map.texel);
  const std::vector<Eigen::AlignedBox3f> contacts = d.add_contacts(instant, block);
  d.use(block);

  d.draw_solid();
  // Scenery casts no shadow: the key light is a stage's light, and walls would shut it out.
  if (solid) d.draw_shadow_map(moving);
  d.lap("shadow map");

  canvas.bind();
  gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
  gl.BindTextureUnit(0, d.shadow_map.id());
  gl.BindTextureUnit(1, d.noise.id());
  if (!solid) {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }
  Reach things;
  for (const Item& item : moving) {
    d.use_surface(*item.drawable, item.model, Shade::shadowed, layer.opacity);
    item.drawable->draw();
    add_box(item.box(), things);
  }
  canvas.touch(pixels(things, block.view_projection, viewport));
  d.lap("figures");
  if (solid) canvas.touch(d.draw_shadows(moving, contacts, block, viewport));
  d.lap("shadows");
}

}  // namespace taut
