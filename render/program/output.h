// Where a command's result goes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "render/base/atomic_file.h"

namespace taut::program {

/// A file, or standard output where the name is - or what that goes to.
class Output {
 public:
  explicit Output(const std::string& name);

  bool is_standard() const { return !file_; }
  std::uint64_t written() const { return written_; }

  /// Throws CannotWrite, as does finish().
  void write(std::string_view bytes);
  /// Until then there is no file of that name.
  void finish();

 private:
  std::optional<render::AtomicFile> file_;
  std::uint64_t written_ = 0;
};

/// Writes a result in words to standard output: names with escapes (see printable_lines()). Throws
/// CannotWrite.
void write_text(std::string_view text);

/// True where such an output goes to standard output.
bool to_standard_output(const std::string& name);

}  // namespace taut::program
