// The files that a model names: buffers, images, libraries of materials.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace taut::scenes {

/// A file that a model names, and where.
struct NamedFile {
  std::string where;     // in the model, for messages: buffers[0].uri "a%20b.bin"
  std::string name;      // relative to the model's folder, decoded
  std::string expected;  // what it should be, as in "a buffer"
};

/// The bytes of the files that a model names. The reader of models opens no file: it looks them up
/// here. Files that it did not find are read afterwards, and the reader starts again.
class NamedFiles {
 public:
  /// The file's bytes; null if there is no such file, or if it was not read yet: then it is
  /// wanted().
  const std::string* find(const NamedFile& file);

  /// Whether read() found no file of that name.
  bool is_missing(const std::string& name) const;

  /// The files that find() was asked for and read() did not read yet.
  const std::vector<NamedFile>& wanted() const { return wanted_; }

  /// Reads these files, relative to the folder of `model`. They and all links to them must lie in
  /// the folder `project` (canonical). Throws BadAsset for a file outside of it, one that is no
  /// regular file or too large, and for too many files.
  void read(const std::filesystem::path& model, const std::filesystem::path& project,
            const std::vector<NamedFile>& files);

  std::size_t size() const { return size_; }  // bytes of all of them

 private:
  std::map<std::string, std::optional<std::string>> bytes_;  // by name; nothing: no such file
  std::vector<NamedFile> wanted_;
  std::size_t size_ = 0;
};

/// A name in quotes for messages; long ones are cut.
std::string in_quotes(std::string_view name);

/// The file name of a relative URI, percent-decoded once. None for a URI with a scheme, an absolute
/// path or a NUL.
std::optional<std::string> name_of_uri(const std::string& uri);

}  // namespace taut::scenes
