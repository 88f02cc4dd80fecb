#include "render/stage_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/drawable.h"
#include "render/lighting.h"
#include "render/noise.h"
#include "render/shaders.h"
#include "render/skinning.h"

namespace taut {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr int kShadowSize = 1536;
constexpr std::size_t kCapsules = 6;
constexpr double kExposure = 0.38;

/// What every surface needs to know of a frame; mirrors the shaders' block.
struct FrameBlock {
  Matrix4f view_projection, light_projection;
  Vector4f eye, to_light, light_color, sky, ground;
  std::array<Vector4f, 9> ambient;
  std::array<Vector4f, kCapsules> capsule_from, capsule_to;
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
};

}  // namespace

struct StageRenderer::Impl {
  Impl(const Context& context, const Stage& s, const World& world)
      : gl(context.gl()),
        stage(s),
        frame(make_buffer(gl)),
        shadow_map(make_texture(gl, GL_DEPTH_COMPONENT24, kShadowSize, kShadowSize)),
        shadow_target(make_framebuffer(gl, 0, shadow_map.id())),
        noise(make_noise_texture(gl)),
        depth_program(gl, shaders::frame_block, shaders::depth_vertex, shaders::depth_fragment),
        ambient(ambient_harmonics(s.light)) {
    const GLuint map = shadow_map.id();
    gl.TextureParameteri(map, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.TextureParameteri(map, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);

    for (const auto& model : stage.scenery) scenery.push_back(drawables(gl, *model));
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

  const Program& program(Surface surface, bool with_capsules) {
    auto& slot = programs[{surface, with_capsules}];
    if (!slot)
      slot = std::make_unique<Program>(
          gl,
          fmt::format("#define EXPOSURE {}\n#define SURFACE {}\n#define CAPSULES {:d}\n{}",
                      kExposure, int(surface), with_capsules, shaders::frame_block),
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

  std::vector<Item> scenery_items() const {
    std::vector<Item> items;
    for (const auto& model : scenery)
      for (const Drawable& part : model) items.push_back({&part, Matrix4f::Identity()});
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

  /// Capsules of the feet and the pelvis: what stands on or near the floor darkens it.
  void find_capsules(const Instant& instant, FrameBlock& block, std::vector<Vec3>& reach) const {
    block.capsule_from.fill(Vector4f::Zero());  // Eigen leaves what it makes unset
    block.capsule_to.fill(Vector4f::Zero());
    std::size_t count = 0;
    const auto add = [&](const Vec3& from, const Vec3& to, double radius) {
      if (count == kCapsules) return;
      block.capsule_from[count] = with_w(from, radius);
      block.capsule_to[count] = with_w(to, 1 / std::max((to - from).squaredNorm(), 1e-6));
      ++count;
      for (int i = 0; i < 8; ++i)
        for (const Vec3& p : {from, to})
          reach.push_back(p + 5 * radius * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    };
    for (std::size_t c = 0; c < std::min(instant.bones.size(), stage.characters.size()); ++c) {
      const std::vector<Bone>& bones = stage.characters[c]->bones;
      for (std::size_t i = 0; i < bones.size(); ++i) {
        const Vec3& at = instant.bones[c][i].position;
        const int parent = bones[i].parent;
        if (bones[i].name.find("Toe") != std::string::npos && parent >= 0)
          add(instant.bones[c][std::size_t(parent)].position, at, 0.055);
        if (bones[i].name.find("Hips") != std::string::npos) add(at, at, 0.16);
      }
    }
  }

  /// The part of the viewport that surrounds these points, clipped to it.
  static Rect around(const std::vector<Vec3>& points, const Matrix4f& projection,
                     const Rect& viewport) {
    Eigen::AlignedBox2d box;
    for (const Vec3& p : points) {
      const Vector4f q = projection * with_w(p, 1);
      if (q.w() < 0.05f) return viewport;
      box.extend(Eigen::Vector2d(0.5 + 0.5 * q.x() / q.w(), 0.5 + 0.5 * q.y() / q.w()));
    }
    if (box.isEmpty()) return {viewport.x, viewport.y, 0, 0};
    const auto pixel = [](double share, int size) {
      return int(std::lround(std::clamp(share, 0.0, 1.0) * size));
    };
    const int left = pixel(box.min().x(), viewport.width),
              right = pixel(box.max().x(), viewport.width);
    const int low = pixel(box.min().y(), viewport.height),
              high = pixel(box.max().y(), viewport.height);
    return {viewport.x + left, viewport.y + low, right - left, high - low};
  }

  void draw_depth(std::span<const Item> items) const {
    depth_program.use();
    for (const Item& item : items) {
      depth_program.set("model", item.model);
      item.drawable->draw();
    }
  }

  void draw_surfaces(std::span<const Item> items, float opacity, bool with_capsules) {
    for (const Item& item : items) {
      const Program& p = program(item.drawable->surface(), with_capsules);
      const Material& material = item.drawable->material();
      p.use();
      p.set("model", item.model);
      p.set("base_color", Vector3f(material.base_color.data()));
      p.set("base_roughness", std::max(material.roughness, 0.08f));
      p.set("metallic", material.metallic);
      p.set("opacity", opacity);
      p.set("grain_axis", item.drawable->grain_axis());
      item.drawable->draw();
    }
  }

  void lap(const char* name) const {
    if (!profile) return;
    gl.Finish();
    profile->lap(name);
  }

  const Gl& gl;
  const Stage& stage;
  Profile* profile = nullptr;
  GlObject frame, shadow_map, shadow_target, noise;
  Program depth_program;
  Harmonics ambient;
  std::map<std::pair<Surface, bool>, std::unique_ptr<Program>> programs;
  std::vector<std::vector<Drawable>> scenery, bodies, characters;
  std::vector<std::unique_ptr<ConnectorMesh>> connector_meshes;
  std::vector<Drawable> connectors;
  std::vector<MovingVertex> vertices;
};

StageRenderer::StageRenderer(const Context& context, const Stage& stage, const World& world)
    : impl_(std::make_unique<Impl>(context, stage, world)) {}

StageRenderer::~StageRenderer() = default;

void StageRenderer::set_profile(Profile* profile) {
  impl_->profile = profile;
}

void StageRenderer::clear(const Canvas& canvas) const {
  const Gl& gl = impl_->gl;
  canvas.bind();
  gl.Disable(GL_SCISSOR_TEST);
  gl.DepthMask(GL_TRUE);
  const Vec3 c = impl_->stage.background.unaryExpr(&encoded);
  gl.ClearColor(float(c.x()), float(c.y()), float(c.z()), 1);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void StageRenderer::draw(const Canvas& canvas, const Rect& viewport, const Instant& instant,
                         const Layer& layer) {
  Impl& d = *impl_;
  const Gl& gl = d.gl;
  d.pose(instant);
  d.lap("skin");
  const std::vector<Item> moving = d.moving_items(instant, layer);
  const std::vector<Item> scenery = layer.scenery ? d.scenery_items() : std::vector<Item>();

  const Light& light = d.stage.light;
  const LightMap map = light_map(light.direction, Impl::casters(instant), kShadowSize);
  FrameBlock block{};
  block.view_projection =
      camera_projection(instant.camera, double(viewport.width) / viewport.height);
  block.light_projection = map.projection;
  block.eye = with_w(instant.camera.position, 1);
  block.to_light = with_w(-light.direction.normalized(), kShadowSize);
  block.light_color = with_w(light.color, 1.5 * map.texel);
  block.sky = with_w(light.sky, 0);
  block.ground = with_w(light.ground, 0);
  for (std::size_t i = 0; i < 9; ++i) block.ambient[i] << d.ambient[i], 0;
  std::vector<Vec3> reach;
  d.find_capsules(instant, block, reach);
  upload(gl, d.frame, std::span<const FrameBlock>(&block, 1), GL_DYNAMIC_DRAW);
  gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, d.frame.id());

  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LESS);
  gl.Enable(GL_CULL_FACE);
  gl.CullFace(GL_BACK);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_SCISSOR_TEST);
  if (layer.opacity >= 1) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, d.shadow_target.id());
    gl.Viewport(0, 0, kShadowSize, kShadowSize);
    gl.DepthMask(GL_TRUE);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    // A lit rim stays, which stands for everything beyond the map.
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(2, 2, kShadowSize - 4, kShadowSize - 4);
    gl.Enable(GL_DEPTH_CLAMP);
    gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(1.5f, 2.0f);
    // Scenery casts no shadow: the key light is a stage's light, and walls would shut it out.
    d.draw_depth(moving);
    gl.Disable(GL_POLYGON_OFFSET_FILL);
    gl.Disable(GL_DEPTH_CLAMP);
    gl.Disable(GL_SCISSOR_TEST);
  } else {
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }

  d.lap("shadow map");
  canvas.bind();
  gl.Viewport(viewport.x, viewport.y, viewport.width, viewport.height);
  gl.BindTextureUnit(0, d.shadow_map.id());
  gl.BindTextureUnit(1, d.noise.id());
  d.draw_surfaces(moving, layer.opacity, false);
  d.lap("figures");
  // Scenery near the feet first, with contact shadows; drawn again, it fails the depth test there.
  const Rect near = Impl::around(reach, block.view_projection, viewport);
  if (near.width > 0 && near.height > 0 && layer.opacity >= 1) {
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(near.x, near.y, near.width, near.height);
    d.draw_surfaces(scenery, 1, true);
    gl.Disable(GL_SCISSOR_TEST);
  }
  d.draw_surfaces(scenery, layer.opacity, false);
  d.lap("scenery");
}

}  // namespace taut
