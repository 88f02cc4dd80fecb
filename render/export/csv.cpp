#include "render/export/csv.h"

#include <fmt/format.h>

#include <algorithm>

namespace taut::exporting {
namespace {

class CsvWriter final : public FrameWriter {
 public:
  CsvWriter(const scenes::Scene& scene, WriteBytes write) : write_(std::move(write)) {
    write_(csv_header(scene) + '\n');
  }
  void add(const ExportState& state) override { write_(csv_row(state.state) + '\n'); }
  void finish() override {}

 private:
  WriteBytes write_;
};

}  // namespace

std::string csv_header(const scenes::Scene& scene) {
  const World world = divided(scene.world, scene.timeline);
  std::string line = "t";
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      for (const char axis : {'x', 'y', 'z'}) {
        line += fmt::format(",{}.{}.{}", connector.name, i, axis);
      }
    }
  }
  for (const Body& body : world.bodies) {
    for (const char* part : {"x", "y", "z", "qw", "qx", "qy", "qz"}) {
      line += fmt::format(",{}.{}", body.name, part);
    }
  }
  for (const Pulley& pulley : world.pulleys) line += fmt::format(",{}.passed", pulley.name);
  return line;
}

std::string csv_row(const Snapshot& state) {
  std::string line = fmt::format("{:.17g}", state.time);
  const auto add = [&line](double number) {
    fmt::format_to(std::back_inserter(line), ",{:.17g}", number);
  };
  for (const auto& particles : state.connectors) {
    for (const Vec3& particle : particles) std::ranges::for_each(particle, add);
  }
  for (const Pose& frame : state.bodies) {
    const Quat& q = frame.rotation;
    std::ranges::for_each(frame.position, add);
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) add(part);
  }
  std::ranges::for_each(state.passed, add);
  return line;
}

std::unique_ptr<FrameWriter> csv_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<CsvWriter>(scene, std::move(write));
}

}  // namespace taut::exporting
