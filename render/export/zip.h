// Zip archives of files that are stored as they are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/export/frame_writer.h"

namespace taut::exporting {

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

}  // namespace taut::exporting
