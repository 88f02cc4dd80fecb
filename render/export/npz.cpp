#include "render/export/npz.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <libdeflate.h>

#include <cstdint>

namespace taut::exporting {
namespace {

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

constexpr U16 kZipVersion = 45;    // with sizes of 64 bits
constexpr U16 kFirstDay = 0x0021;  // 1 January 1980
constexpr U32 kElsewhere = 0xffffffff;
constexpr U16 kElsewhere16 = 0xffff;

}  // namespace

void Zip::put(std::string_view bytes) {
  write_(bytes);
  written_ += bytes.size();
}

void Zip::add(const std::string& name, const std::vector<std::string_view>& pieces) {
  U64 size = 0;
  U32 sum = 0;
  for (const std::string_view piece : pieces) {
    size += piece.size();
    sum = libdeflate_crc32(sum, piece.data(), piece.size());
  }
  const U64 offset = written_;
  // Flags (names in UTF-8), stored, time, date, sum, sizes in the extra field.
  const std::string common = little_endian(kZipVersion, U16(0x0800), U16(0), U16(0), kFirstDay, sum,
                                           kElsewhere, kElsewhere, U16(name.size()));
  put(little_endian(U32(0x04034b50)) + common + little_endian(U16(20)) + name +
      little_endian(U16(1), U16(16), size, size));
  for (const std::string_view piece : pieces) put(piece);
  list_ += little_endian(U32(0x02014b50), kZipVersion) + common +
           little_endian(U16(28), U16(0), U16(0), U16(0), U32(0), kElsewhere) + name +
           little_endian(U16(1), U16(24), size, size, offset);
  ++files_;
}

void Zip::finish() {
  const U64 list = written_, end = written_ + list_.size();
  put(list_);
  put(little_endian(U32(0x06064b50), U64(44), kZipVersion, kZipVersion, U32(0), U32(0), files_,
                    files_, U64(list_.size()), list));
  put(little_endian(U32(0x07064b50), U32(0), end, U32(1)));
  put(little_endian(U32(0x06054b50), U16(0), U16(0), kElsewhere16, kElsewhere16, kElsewhere,
                    kElsewhere, U16(0)));
}

namespace {

/// Rows of one array, gathered frame by frame.
struct Array {
  std::string name;
  std::vector<std::size_t> row = {};  // the shape of a row
  std::vector<double> numbers = {};

  void add(const Vec3& v) { numbers.insert(numbers.end(), v.begin(), v.end()); }
};

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
    for (const Array& array : arrays_) {
      std::vector<std::size_t> shape = {rows_};
      shape.insert(shape.end(), array.row.begin(), array.row.end());
      zip_.add(array.name + ".npy",
               {npy_header("<f8", shape), bytes_of(std::span<const double>(array.numbers))});
    }
    zip_.finish();
  }

 private:
  Zip zip_;
  std::vector<Array> arrays_;
  std::size_t rows_ = 0;
};

}  // namespace

std::string npy_header(std::string_view type, const std::vector<std::size_t>& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                 type, fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  constexpr std::size_t kBefore = 10;
  text.append(63 - (kBefore + text.size()) % 64, ' ');
  text += '\n';
  return "\x93NUMPY" + little_endian(std::uint8_t(1), std::uint8_t(0), std::uint16_t(text.size())) +
         text;
}

std::unique_ptr<FrameWriter> npz_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<NpzWriter>(scene, std::move(write));
}

}  // namespace taut::exporting
