#include "render/export/npz.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>

#include "render/export/little_endian.h"
#include "render/export/zip.h"

namespace taut::exporting {
namespace {

/// Rows of one array, gathered frame by frame.
struct Array {
  std::string name;
  std::vector<std::size_t> row = {};  // the shape of a row
  std::vector<double> numbers = {};

  void add(const Vec3& v) { numbers.insert(numbers.end(), v.begin(), v.end()); }
};

/// The head of an .npy file, a multiple of 64 bytes.
std::string npy_header(const Array& array, std::size_t rows) {
  std::string shape = fmt::format("{},", rows);
  for (const std::size_t size : array.row) shape += fmt::format(" {},", size);
  if (!array.row.empty()) shape.pop_back();
  std::string text =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape);
  constexpr std::size_t kBefore = 10;
  text.append(63 - (kBefore + text.size()) % 64, ' ');
  text += '\n';
  return "\x93NUMPY" + little_endian(std::uint8_t(1), std::uint8_t(0), std::uint16_t(text.size())) +
         text;
}

class NpzWriter final : public FrameWriter {
 public:
  NpzWriter(const scenes::Scene& scene, WriteBytes write) : zip_(std::move(write)) {
    const World world = divided(scene.world, scene.timeline);
    arrays_.push_back({"times"});
    for (const Connector& connector : world.connectors)
      for (const char* what : {"positions", "velocities"})
        arrays_.push_back(
            {fmt::format("connectors/{}/{}", connector.name, what), {connector.particles(), 3}});
    for (const Body& body : world.bodies) {
      arrays_.push_back({fmt::format("bodies/{}/positions", body.name), {3}});
      arrays_.push_back({fmt::format("bodies/{}/rotations", body.name), {4}});
    }
  }

  void add(const ExportState& state) override {
    ++rows_;
    auto array = arrays_.begin();
    array++->numbers.push_back(state.state.time);
    for (std::size_t i = 0; i < state.velocities.size(); ++i) {
      for (const Vec3& position : state.state.connectors[i]) array->add(position);
      ++array;
      for (const Vec3& velocity : state.velocities[i]) array->add(velocity);
      ++array;
    }
    for (const Pose& frame : state.state.bodies) {
      array++->add(frame.position);
      const Quat& q = frame.rotation;
      for (const double part : {q.w(), q.x(), q.y(), q.z()}) array->numbers.push_back(part);
      ++array;
    }
  }

  void finish() override {
    for (const Array& array : arrays_)
      zip_.add(array.name + ".npy",
               {npy_header(array, rows_), bytes_of(std::span<const double>(array.numbers))});
    zip_.finish();
  }

 private:
  Zip zip_;
  std::vector<Array> arrays_;
  std::size_t rows_ = 0;
};

}  // namespace

std::unique_ptr<FrameWriter> npz_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<NpzWriter>(scene, std::move(write));
}

}  // namespace taut::exporting
