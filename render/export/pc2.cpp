#include <cstdint>

#include "render/export/frame_writer.h"

namespace taut::exporting {
namespace {

class Pc2Writer final : public FrameWriter {
 public:
  Pc2Writer(const scenes::Scene& scene, WriteBytes write) : write_(std::move(write)) {
    std::int32_t points = 0;
    for (const Connector& connector : divided(scene.world, scene.timeline).connectors)
      points += std::int32_t(connector.particles());
    constexpr std::int32_t kVersion = 1;
    constexpr float kFirst = 0, kFramesApart = 1;
    write_(std::string("POINTCACHE2", 12) +
           little_endian(kVersion, points, kFirst, kFramesApart, std::int32_t(scene.frames())));
  }
  void add(const ExportState& state) override {
    std::vector<float> numbers;
    for (const auto& particles : state.state.connectors)
      for (const Vec3& p : particles)
        for (const double number : p) numbers.push_back(float(number));
    write_(bytes_of(std::span<const float>(numbers)));
  }
  void finish() override {}

 private:
  WriteBytes write_;
};

}  // namespace

std::unique_ptr<FrameWriter> pc2_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<Pc2Writer>(scene, std::move(write));
}

}  // namespace taut::exporting
