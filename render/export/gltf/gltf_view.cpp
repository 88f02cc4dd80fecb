#include "render/export/gltf/gltf_view.h"

#include <algorithm>

namespace taut::exporting {

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

}  // namespace taut::exporting
