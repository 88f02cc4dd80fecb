// Trajectories as arrays for numpy.load(), in a zip archive.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/export/frame_writer.h"

namespace taut::exporting {

// Zip archives of files that are stored as they are.

/// The same files give the same bytes: none has a date.
class Zip {
 public:
  explicit Zip(WriteBytes write) : write_(std::move(write)) {}

  /// A file of these pieces, one after another.
  void add(const std::string& name, const std::vector<std::string_view>& pieces);
  /// The list of the files, which ends an archive.
  void finish();

 private:
  void put(std::string_view bytes);

  WriteBytes write_;
  std::uint64_t written_ = 0, files_ = 0;
  std::string list_;
};

/// An archive of arrays of float64, a row for each frame: `times`; for every connector
/// `connectors/NAME/positions` and `connectors/NAME/velocities` (frames, particles, 3); for every
/// body `bodies/NAME/positions` (frames, 3), of its own frame, and `bodies/NAME/rotations`
/// (frames, 4), quaternions w, x, y, z.
std::unique_ptr<FrameWriter> npz_writer(const scenes::Scene& scene, WriteBytes write);

/// The head of an .npy file, a multiple of 64 bytes: the type of its elements, as numpy writes it,
/// and its shape.
std::string npy_header(std::string_view type, const std::vector<std::size_t>& shape);

}  // namespace taut::exporting
