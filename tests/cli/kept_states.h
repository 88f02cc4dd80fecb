// The input of an export of a scene.
#pragma once

#include <string>

#include "render/export/frame_writer.h"
#include "scenes/load/load_scene.h"

namespace taut {

/// The states at frames and between, as formats are given them.
inline std::vector<exporting::ExportState> states_of(const scenes::Scene& scene) {
  class Keeper final : public exporting::FrameWriter {
   public:
    explicit Keeper(int parts) : parts_(parts) {}
    int states_per_frame() const override { return parts_; }
    void add(const exporting::ExportState& state) override { states.push_back(state); }
    void finish() override {}
    std::vector<exporting::ExportState> states;

   private:
    int parts_;
  };
  Keeper keeper(exporting::parts_of_frame(scene));
  exporting::play(scene, keeper, [](int) {});
  return keeper.states;
}

/// The bytes of a format.
template <typename MakeWriter>
std::string exported(const scenes::Scene& scene, MakeWriter make) {
  std::string bytes;
  const auto writer = make(scene, [&](std::string_view more) { bytes += more; });
  exporting::play(scene, *writer, [](int) {});
  return bytes;
}

/// A scene of the repository.
inline scenes::Scene scene_of(const std::string& name) {
  return scenes::load_scene(std::filesystem::path(TAUT_SOURCE_DIR) / "scenes" / name, true);
}

}  // namespace taut
