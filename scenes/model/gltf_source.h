// A glTF file as read: its JSON with typed access, its buffers, and accessors proved to be in
// range.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/files/regular_file.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

using Json = nlohmann::json;

/// Component types of accessors (glTF 2.0, section 3.6.2.2).
enum GltfComponent : std::uint64_t {
  i8 = 5120,
  u8 = 5121,
  i16 = 5122,
  u16 = 5123,
  u32 = 5125,
  f32 = 5126
};

/// Whether a model is read with all that this extension adds to it.
bool is_supported_extension(std::string_view name);

/// An accessor whose elements all lie inside the buffers.
struct GltfAccessor {
  std::size_t offset = 0;  // of the first element in GltfSource::binary(), bytes
  std::size_t stride = 0, count = 0, elements = 0;
  std::uint64_t component = 0;
  std::string type;
  bool normalized = false;

  std::size_t item_size() const;  // bytes
};

/// All members throw BadAsset for what the file gets wrong; `where` names the place in messages, as
/// in "meshes[2]".
class GltfSource {
 public:
  /// Reads the container (GLB or plain JSON) and every buffer. Nothing else may be asked of it
  /// where `files`, which it takes those from that lie in files of their own, wants some of them.
  GltfSource(const std::filesystem::path& file, const std::string& content, NamedFiles& files);

  template <typename... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) const {
    throw bad_asset(file_, fmt::format(text, std::forward<Args>(args)...));
  }

  const Json& root() const { return json_; }
  /// An array of the root, or an empty one.
  const Json& list(const char* key) const { return list(json_, key, "its JSON"); }
  const Json& list(const Json& in, const char* key, const std::string& where) const;
  /// An object in an array of the root.
  const Json& item(const char* key, std::size_t index) const;
  std::size_t whole(const Json& in, const char* key, const std::string& where,
                    std::optional<std::size_t> fallback = {}) const;
  std::size_t index(const Json& value, std::size_t count, const std::string& what) const;
  double number(const Json& value, const std::string& what) const;
  /// The object's name as it is printable(), or `fallback` where it has none.
  std::string name(const Json& in, const std::string& fallback) const;

  /// The accessor that `value` is the index of.
  GltfAccessor accessor(const Json& value, const std::string& used_by) const;
  /// The bytes of an image (PNG or another format); nothing where `files` has yet to get it.
  std::optional<std::string> image(std::size_t index, NamedFiles& files) const;

  /// One unsigned component of an accessor.
  std::uint32_t integer(const GltfAccessor& a, std::size_t item, std::size_t element) const;
  /// One component of any type; a normalized one as a share of 1 (glTF 2.0, section 3.6.2.2).
  float component(const GltfAccessor& a, std::size_t item, std::size_t element) const;

  /// All buffers, one after the other, each from a multiple of 4.
  const std::string& binary() const { return binary_; }

 private:
  void read_container(const std::string& content);
  void gather_buffers(NamedFiles& files);
  /// What a uri says or names; nothing where `files` has yet to get it.
  std::optional<std::string> from_uri(const Json& uri, const std::string& where,
                                      const char* expected, NamedFiles& files) const;
  /// Where the view that `value` is the index of starts in binary(), and its length; bytes.
  std::pair<std::size_t, std::size_t> view(const Json& value, const std::string& used_by) const;
  std::string from_base64(const std::string& text, const std::string& where) const;

  const std::filesystem::path& file_;
  Json json_;
  std::string binary_;
  std::optional<std::string> chunk_;                          // the BIN chunk of a GLB
  std::vector<std::pair<std::size_t, std::size_t>> buffers_;  // start in binary_, length
};

}  // namespace taut::scenes
