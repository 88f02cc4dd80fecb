#include "render/film/fingerprint.h"

#include <string>

#include "scenes/files/regular_file.h"
#include "sim/motion/hash.h"

namespace taut::film {
namespace {

void add(Hash& hash, const Vec3& v) {
  hash.number(v.x()).number(v.y()).number(v.z());
}

void add(Hash& hash, const Pose& pose) {
  add(hash, pose.position);
  const Quat& q = pose.rotation;
  hash.number(q.w()).number(q.x()).number(q.y()).number(q.z());
}

void add(Hash& hash, const scenes::Model& model) {
  for (const scenes::Texture& t : model.textures) {
    hash.number(t.width).number(t.height).number(t.wrap_u).number(t.wrap_v);
    hash.number(t.magnify).number(t.minify).bytes(t.pixels.data(), t.pixels.size());
  }
  for (const scenes::Material& m : model.materials)
    hash.text(m.name).number(m.texture).number(m.base_color).number(m.roughness).number(m.metallic);
  for (const scenes::Mesh& mesh : model.meshes) {
    hash.number(mesh.material).number(mesh.vertices.size());
    for (const scenes::Vertex& v : mesh.vertices)
      hash.number(v.position)
          .number(v.normal)
          .number(v.color)
          .number(v.uv)
          .number(v.bones)
          .number(v.weights);
    hash.number(mesh.indices.size())
        .bytes(mesh.indices.data(), mesh.indices.size() * sizeof mesh.indices[0]);
  }
  for (const scenes::Bone& bone : model.bones)
    for (const float entry : bone.inverse_bind.reshaped()) hash.number(entry);
}

void add(Hash& hash, const std::vector<std::shared_ptr<const scenes::Model>>& models) {
  hash.number(models.size());
  for (const auto& model : models) {
    hash.number(model != nullptr);
    if (model) add(hash, *model);
  }
}

}  // namespace

std::uint64_t program_fingerprint() {
  const std::string bytes = scenes::read_bytes("/proc/self/exe");
  return Hash().bytes(bytes.data(), bytes.size()).value();
}

std::uint64_t fingerprint(const scenes::Stage& stage) {
  Hash hash;
  const scenes::Light& light = stage.light;
  for (const Vec3& v :
       {light.direction, light.color, light.sky, light.ground, light.rim, stage.background})
    add(hash, v);
  hash.number(light.scenery_casts);
  add(hash, stage.scenery);
  add(hash, stage.body_models);
  add(hash, stage.characters);
  for (const scenes::ConnectorLook& look : stage.connector_looks) {
    hash.number(look.kind).number(look.diameter);
    add(hash, look.color);
    hash.number(look.knob);
  }
  for (const scenes::Caption& caption : stage.captions)
    hash.number(caption.from).number(caption.until).text(caption.text).text(caption.list);
  for (const scenes::Trail& trail : stage.trails) {
    hash.number(trail.lasts).number(trail.width);
    add(hash, trail.color);
  }
  for (const scenes::Card& card : {stage.title, stage.end}) hash.text(card.heading).text(card.text);
  return hash.value();
}

std::uint64_t fingerprint(std::span<const draw::FrameState> shutter) {
  Hash hash;
  for (const draw::FrameState& instant : shutter) {
    hash.number(instant.state.time);
    for (const auto& particles : instant.state.connectors)
      for (const Vec3& p : particles) add(hash, p);
    for (const Pose& body : instant.state.bodies) add(hash, body);
    for (const auto& bones : instant.bones)
      for (const Pose& bone : bones) add(hash, bone);
    for (const scenes::TrailPoints& trail : instant.trails) {
      for (const double age : trail.ages) hash.number(age);
      for (const Vec3& place : trail.places) add(hash, place);
    }
    add(hash, instant.camera.position);
    add(hash, instant.camera.target);
    hash.number(instant.camera.field_of_view)
        .number(instant.camera.relative_aperture)
        .number(instant.camera.focus);
  }
  return hash.value();
}

}  // namespace taut::film
