#include "render/export/gltf/glb.h"

#include <fmt/format.h>

#include <deque>

#include "render/export/gltf/gltf_connector.h"
#include "render/export/gltf/gltf_figure.h"
#include "render/export/gltf/gltf_view.h"
#include "render/export/gltf/spline_tracks.h"
#include "render/export/looks.h"
#include "scenes/format/document.h"
#include "scenes/scene/names.h"

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

}  // namespace taut::exporting
