// Files that another program writes for this run alone.
#pragma once

#include <filesystem>
#include <optional>

#include "render/base/leftovers.h"

namespace taut::render {

/// An empty file beside NAME, called NAME.XXXX.part by chance: whatever writes there after its run
/// was killed writes to no file of another run. commit() makes it NAME; without a commit the
/// destructor removes it.
class PartFile {
 public:
  /// Removes what killed runs left beside NAME. Throws CannotWrite.
  explicit PartFile(std::filesystem::path name);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const { return part_; }

  /// The error number for what the file lacks (ENOSPC, EDQUOT, EFBIG, EIO), or 0. A file that was
  /// cut short by a full disk or a limit cannot take one more byte: that is tried, and undone.
  /// Bytes that are there go to the disk.
  int why_full() const;

  /// Throws CannotWrite.
  void commit();

 private:
  std::filesystem::path name_, part_;
  std::optional<UnfinishedFile> unfinished_;
  int lock_ = -1;  // open while the run lives: by it others know the file for no leftover
};

}  // namespace taut::render
