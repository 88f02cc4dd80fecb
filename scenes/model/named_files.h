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

/// The bytes of the files that a model names. The reader of models opens none of them: it asks for
/// them here, and is started again with those that it did not find.
class NamedFiles {
 public:
  /// The file's bytes; nothing where there is no such file, or none yet: then it is wanted().
  const std::string* find(const NamedFile& file);

  /// Whether it was looked for, and is not there.
  bool is_missing(const std::string& name) const;

  /// The files that were asked for and not looked for yet.
  const std::vector<NamedFile>& wanted() const { return wanted_; }

  /// Reads such files from beside `model`, which lies in the folder `project` (canonical): regular
  /// files in it, reached by links inside of it. Throws BadAsset: one that leads out of it, is no
  /// regular file or too large, or too many of them.
  void read(const std::filesystem::path& model, const std::filesystem::path& project,
            const std::vector<NamedFile>& files);

  std::size_t size() const { return size_; }  // bytes of all of them

 private:
  std::map<std::string, std::optional<std::string>> bytes_;  // by name; nothing: no such file
  std::vector<NamedFile> wanted_;
  std::size_t size_ = 0;
};

/// A name as messages quote it: cut where it is long.
std::string in_quotes(std::string_view name);

/// The name that a relative uri stands for: %20 is a space, and so on, decoded once. Nothing where
/// it is of another kind: with a scheme, from a root, or with a NUL in it.
std::optional<std::string> name_of_uri(const std::string& uri);

}  // namespace taut::scenes
