#include "render/export/gltf/glb.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "render/export/frame_writer.h"
#include "render/export/gltf/gltf_connector.h"
#include "render/export/gltf/gltf_motion.h"
#include "scenes/format/document.h"
#include "scenes/scene/scene.h"

namespace taut::exporting {
namespace {

class GlbWriter final : public FrameWriter {
 public:
  GlbWriter(const scenes::Scene& scene, WriteBytes write)
      : scene_(scene), write_(std::move(write)), world_(divided(scene.world, scene.timeline)) {
    file_.name_scene(scene.title);
    add_bodies();
    add_connectors();
    if (!scene.stage) return;
    const scenes::Stage& stage = *scene.stage;
    for (std::size_t i = 0; i < stage.characters.size(); ++i)
      figures_.emplace_back(
          file_, meshes_,
          stage.characters.size() == 1 ? "character" : fmt::format("character {}", i + 1),
          *stage.characters[i]);
    for (const auto& model : stage.scenery)
      file_.node(file_.add_node(model->name))["mesh"] = meshes_.of_model(*model);
    view_.emplace(file_, scene);
  }

  int states_per_frame() const override { return parts_of_frame(scene_); }

  void add(const ExportState& state) override {
    SplineTracks::State moved{state.state.time, {}, state.state.bodies};
    for (const auto& particles : state.state.connectors)
      moved.points.insert(moved.points.end(), particles.begin(), particles.end());
    states_.push_back(state.state);
    tracks_->add(std::move(moved), state.frame, [&](std::size_t key) {
      for (; dropped_ < key; ++dropped_) states_.pop_front();
      add_key(states_.front());
    });
  }

  void finish() override {
    std::size_t point = 0;
    for (const GltfConnector& connector : connectors_)
      for (const std::size_t node : connector.particles())
        motion_.spline_translation(node, tracks_->point(point++));
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      motion_.spline_translation(bodies_[i], tracks_->position(i));
      motion_.spline_rotation(bodies_[i], tracks_->rotation(i));
    }
    motion_.finish("motion", tracks_->times());
    file_.write(write_);
  }

  Figures figures() const override {
    return {{"keys", tracks_->times().size()},
            {"particles_between_frames_off_by_m", tracks_->point_error()},
            {"bodies_between_frames_off_by_m", tracks_->frame_error()}};
  }

 private:
  void add_bodies() {
    for (std::size_t i = 0; const auto& model : body_models(scene_)) {
      const Body& body = world_.bodies[i++];
      const std::size_t node = file_.add_node(body.name);
      file_.node(node)["extras"] = {{"mass_kg", body.mass_properties.mass}};
      if (model) file_.node(node)["mesh"] = meshes_.of_model(*model);
      bodies_.push_back(node);
    }
  }

  void add_connectors() {
    constexpr std::size_t kMostJoints = 65536;
    std::size_t points = 0;
    for (std::size_t i = 0; const Connector& connector : world_.connectors) {
      if (connector.particles() > kMostJoints)
        scenes::fail_at(scene_.file,
                        {"connectors", std::string(scenes::written_name(connector.name))},
                        fmt::format("{} has {} particles, expected at most {} for a glTF file",
                                    connector.name, connector.particles(), kMostJoints));
      connectors_.emplace_back(file_, meshes_, connector, look_of(scene_, i++), bodies_,
                               body_models(scene_));
      for (const std::size_t joint : connectors_.back().joints()) motion_.keep(joint);
      points += connector.particles();
    }
    tracks_.emplace(points, bounding_radii(scene_));
  }

  void add_key(const Snapshot& state) {
    for (std::size_t i = 0; i < connectors_.size(); ++i)
      connectors_[i].turn(state.connectors[i], state.bodies, motion_);
    for (std::size_t i = 0; i < figures_.size(); ++i)
      figures_[i].pose(scene_.performances[i]->bones_at(state.time), motion_);
    if (view_) view_->place(state.time, motion_);
  }

  const scenes::Scene& scene_;
  WriteBytes write_;
  World world_;
  GltfFile file_;
  GltfMeshes meshes_{file_};
  GltfMotion motion_{file_};
  std::vector<std::size_t> bodies_;  // nodes
  std::vector<GltfConnector> connectors_;
  std::vector<GltfFigure> figures_;
  std::optional<GltfView> view_;
  std::optional<SplineTracks> tracks_;
  std::deque<Snapshot> states_;  // since the last key
  std::size_t dropped_ = 0;      // before these
};

}  // namespace

std::unique_ptr<FrameWriter> glb_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<GlbWriter>(scene, std::move(write));
}

GltfView::GltfView(GltfFile& file, const scenes::Scene& scene) {
  for (const NamedCamera& camera : cameras(scene)) {
    const std::size_t lens =
        file.add("cameras", {{"name", camera.name},
                             {"type", "perspective"},
                             {"perspective",
                              {{"aspectRatio", double(scene.width) / scene.height},
                               {"yfov", scenes::camera_at(camera.keys, camera.start).field_of_view},
                               {"znear", 0.05},
                               {"zfar", 60}}}});
    const std::size_t node = file.add_node(camera.name);
    file.node(node)["camera"] = lens;
    cameras_.push_back({node, camera});
  }
  const scenes::Light& light = scene.stage->light;
  const double brightest = std::max(light.color.maxCoeff(), 1e-9);
  const Vec3 color = light.color / brightest;
  const char* const extension = "KHR_lights_punctual";
  const char* const name = "key light";
  file.use_extension(extension, {{"lights",
                                  {{{"name", name},
                                    {"type", "directional"},
                                    {"color", {color.x(), color.y(), color.z()}},
                                    {"intensity", brightest}}}}});
  const std::size_t node = file.add_node(name);
  file.node(node)["extensions"] = {{extension, {{"light", 0}}}};
  file.place(node, {Vec3::Zero(), looking(light.direction)});
}

void GltfView::place(double time, GltfMotion& motion) const {
  for (const auto& [node, camera] : cameras_) {
    const scenes::CameraView view = scenes::camera_at(camera.keys, time);
    motion.translate(node, view.position);
    motion.turn(node, looking(view.target - view.position));
  }
}

GltfFigure::GltfFigure(GltfFile& file, GltfMeshes& meshes, const std::string& name,
                       const scenes::Model& model)
    : model_(model) {
  const std::size_t group = file.add_node(name);
  for (const scenes::Bone& bone : model.bones)
    bones_.push_back(
        file.add_node(bone.name, bone.parent < 0 ? group : bones_[std::size_t(bone.parent)]));
  std::vector<std::size_t> joints = bones_;
  std::vector<float> inverse_bind;
  for (const scenes::Bone& bone : model.bones) {
    Eigen::Matrix4f m = bone.inverse_bind;
    m.row(3) << 0, 0, 0, 1;
    inverse_bind.insert(inverse_bind.end(), m.data(), m.data() + m.size());
  }
  if (GltfMeshes::has_fixed_vertices(model)) {
    joints.push_back(group);
    const Eigen::Matrix4f none = Eigen::Matrix4f::Identity();
    inverse_bind.insert(inverse_bind.end(), none.data(), none.data() + none.size());
  }
  const std::size_t skin = file.add(
      "skins", {{"name", name},
                {"inverseBindMatrices",
                 file.add_numbers(std::span<const float>(inverse_bind), {GltfFile::f32, "MAT4"})},
                {"skeleton", group},
                {"joints", joints}});
  const std::size_t node = file.add_node(name + " skin");
  file.node(node)["mesh"] = meshes.of_model(model);
  file.node(node)["skin"] = skin;
}

void GltfFigure::pose(std::span<const Pose> bones, GltfMotion& motion) const {
  for (std::size_t i = 0; i < bones_.size(); ++i) {
    const int parent = model_.bones[i].parent;
    const Pose above = parent < 0 ? Pose() : bones[std::size_t(parent)];
    const Quat back = above.rotation.conjugate();
    motion.translate(bones_[i], back * (bones[i].position - above.position));
    motion.turn(bones_[i], back * bones[i].rotation);
  }
}

}  // namespace taut::exporting
