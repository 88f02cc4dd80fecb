// The results of a long study so far, on the disk, so that a run that was stopped goes on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "render/base/descriptor.h"

namespace taut::program {

/// Rows of text under a key each. A row is on the disk when add() returns; a row that a crash cut
/// short is forgotten.
class Journal {
 public:
  /// Takes up the rows of `file` where it was written under the same `stamp`: of everything that
  /// decides what the rows say. Starts anew otherwise. Throws CannotWrite, also when another run is
  /// writing it.
  Journal(std::filesystem::path file, std::uint64_t stamp);
  /// Only to look up: the rows of those `files` that were written under the stamp, of two under a
  /// key that of the later file. Throws BadAsset where one cannot be read.
  Journal(const std::vector<std::filesystem::path>& files, std::uint64_t stamp);

  /// The row's cells, or null.
  const std::vector<std::string>* find(const std::string& key) const;
  /// Throws CannotWrite.
  void add(const std::string& key, const std::vector<std::string>& cells);
  /// How many rows were taken up.
  std::size_t kept() const { return kept_; }
  /// Removes the file: the study is complete, and its next run starts anew. Throws
  /// CannotWrite.
  void finish();

 private:
  [[noreturn]] void fail(const char* action) const;
  bool take_up(const std::string& text, std::uint64_t stamp);

  std::filesystem::path name_;
  render::Descriptor file_;
  std::size_t kept_ = 0;
  std::map<std::string, std::vector<std::string>> rows_;
};

/// A number as text that reads back as the same number, infinities and not-a-number included.
std::string exact(double value);
double number_in(const std::string& text);

}  // namespace taut::program
