// glTF files, proved sound and reduced to what a model uses. The structure follows the glTF 2.0
// specification (Khronos, 2021), sections 3.5 to 3.9 and 4.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/files/files.h"
#include "scenes/model/formats.h"
#include "scenes/model/model.h"
#include "scenes/model/named_files.h"
#include "sim/motion/printable.h"

namespace taut::scenes {
namespace {

// The file as read: JSON with typed access, buffers, and accessors proved to be in range.

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

constexpr int nesting_limit = 64;  // of JSON values
constexpr std::size_t name_limit = 200;
constexpr std::size_t header = 12, chunk_header = 8;  // of a GLB, bytes
constexpr std::uint32_t json_chunk = 0x4E4F534A, bin_chunk = 0x004E4942;

std::size_t size_of(std::uint64_t component) {
  if (component == i8 || component == u8) return 1;
  return component == i16 || component == u16 ? 2 : 4;
}

std::size_t elements_of(const std::string& type) {
  static const std::map<std::string, std::size_t> counts = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const auto found = counts.find(type);
  return found == counts.end() ? 0 : found->second;
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at, std::size_t size = 4) {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// Whether the shape of a model is the same without this extension, which changes its look.
bool changes_looks(std::string_view extension) {
  constexpr std::string_view kinds[] = {"KHR_materials_", "KHR_texture_", "KHR_lights_",
                                        "EXT_texture_",   "EXT_lights_",  "MSFT_texture_"};
  return std::ranges::any_of(kinds, [&](std::string_view k) { return extension.starts_with(k); });
}

/// How deep lists and objects of a JSON text lie in each other.
int nesting(const std::string& text) {
  int depth = 0, most = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted) {
      if (c == '\\') ++i;
    } else if (c == '{' || c == '[') {
      most = std::max(most, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return most;
}

std::size_t GltfAccessor::item_size() const {
  return elements * size_of(component);
}

/// Whether a model is read with all that this extension adds to it.
bool is_supported_extension(std::string_view name) {
  return name == "KHR_mesh_quantization" || name == "KHR_texture_transform" ||
         name == "KHR_materials_pbrSpecularGlossiness";
}

GltfSource::GltfSource(const std::filesystem::path& file, const std::string& content,
                       NamedFiles& files)
    : file_(file) {
  read_container(content);
  for (const Json& name : list("extensionsRequired")) {
    const std::string text = name.is_string() ? name.get<std::string>() : "";
    if (!is_supported_extension(text) && !changes_looks(text))
      fail("needs the extension {}, which is not supported", name.dump());
  }
  gather_buffers(files);
}

void GltfSource::read_container(const std::string& content) {
  std::string text = content;
  if (content.compare(0, 4, "glTF") == 0) {
    const std::size_t first = header + chunk_header;
    if (content.size() < first) fail("truncated: {} bytes are too few for a GLB", content.size());
    if (little_endian(content, 4) != 2)
      fail("GLB version {}, expected 2", little_endian(content, 4));
    const std::size_t length = little_endian(content, 8);
    if (length > content.size())
      fail("truncated: its header says {} bytes, the file has {}", length, content.size());
    if (length < first) fail("its header says {} bytes, too few for a GLB", length);
    const std::size_t json_size = little_endian(content, header);
    if (little_endian(content, header + 4) != json_chunk) fail("its first chunk is not JSON");
    if (json_size > length - first) fail("its JSON chunk of {} bytes does not fit", json_size);
    text = content.substr(first, json_size);
    const std::size_t second = first + (json_size + 3) / 4 * 4;
    if (second + chunk_header <= length) {
      const std::size_t size = little_endian(content, second);
      if (little_endian(content, second + 4) != bin_chunk) fail("its second chunk is not BIN");
      if (size > length - second - chunk_header)
        fail("its BIN chunk of {} bytes does not fit", size);
      chunk_ = content.substr(second + chunk_header, size);
    }
  } else if (file_.extension() == ".glb") {
    fail("not a GLB file: it does not start with \"glTF\"");
  }
  // A parser that recurses, as the importer's does, would run out of stack on deeply nested text.
  if (nesting(text) > nesting_limit) fail("JSON nested more than {} deep", nesting_limit);
  try {
    json_ = Json::parse(text);
  } catch (const Json::exception& error) {
    fail("broken JSON: {}", error.what());
  }
  if (!json_.is_object()) fail("its JSON is not an object");
  const auto asset = json_.find("asset");
  if (asset == json_.end() || !asset->is_object()) fail("its asset must be an object");
  const Json version = asset->value("version", Json());
  if (!version.is_string() || version.get_ref<const std::string&>().compare(0, 2, "2.") != 0)
    fail("asset.version is {}, expected \"2.0\"", version.dump());
}

const Json& GltfSource::list(const Json& in, const char* key, const std::string& where) const {
  static const Json none = Json::array();
  const auto found = in.find(key);
  if (found == in.end()) return none;
  if (!found->is_array()) fail("{}: {} must be an array", where, key);
  return *found;
}

const Json& GltfSource::item(const char* key, std::size_t index) const {
  const Json& object = list(key)[index];
  if (!object.is_object()) fail("{}[{}] must be an object", key, index);
  return object;
}

std::size_t GltfSource::whole(const Json& in, const char* key, const std::string& where,
                              std::optional<std::size_t> fallback) const {
  const auto found = in.find(key);
  if (found == in.end()) {
    if (!fallback) fail("{} lacks {}", where, key);
    return *fallback;
  }
  if (!found->is_number_unsigned()) fail("{}.{} must be a whole number", where, key);
  const auto value = found->get<std::uint64_t>();
  if (value > std::numeric_limits<std::uint32_t>::max()) fail("{}.{} is too large", where, key);
  return value;
}

std::size_t GltfSource::index(const Json& value, std::size_t count, const std::string& what) const {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= count)
    fail("{} is {}, expected an index below {}", what, value.dump(), count);
  return value.get<std::size_t>();
}

double GltfSource::number(const Json& value, const std::string& what) const {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    fail("{} must be a finite number", what);
  return value.get<double>();
}

std::string GltfSource::name(const Json& in, const std::string& fallback) const {
  const auto found = in.find("name");
  if (found == in.end() || !found->is_string()) return fallback;
  const auto& text = found->get_ref<const std::string&>();
  // The importer would cut it at a NUL.
  return text.empty() || text.size() > name_limit ? fallback : printable(text);
}

void GltfSource::gather_buffers(NamedFiles& files) {
  for (std::size_t i = 0; i < list("buffers").size(); ++i) {
    const Json& buffer = item("buffers", i);
    const std::string where = fmt::format("buffers[{}]", i);
    const std::size_t length = whole(buffer, "byteLength", where);
    std::string bytes;
    if (const auto uri = buffer.find("uri"); uri != buffer.end()) {
      auto found = from_uri(*uri, where + ".uri", "a buffer", files);
      if (!found) continue;
      bytes = std::move(*found);
    } else {
      if (i > 0 || !chunk_) fail("{} has neither a uri nor a BIN chunk", where);
      bytes = *chunk_;
    }
    if (length > bytes.size())
      fail("truncated: {} says {} bytes, but there are {}", where, length, bytes.size());
    if (binary_.size() + length > model_limits::bytes)
      fail("its buffers are larger than {} MiB", model_limits::bytes >> 20);
    buffers_.emplace_back(binary_.size(), length);
    binary_.append(bytes, 0, length);
    binary_.resize((binary_.size() + 3) / 4 * 4);
  }
}

std::optional<std::string> GltfSource::from_uri(const Json& value, const std::string& where,
                                                const char* expected, NamedFiles& files) const {
  if (!value.is_string()) fail("{} must be a string", where);
  const auto& uri = value.get_ref<const std::string&>();
  if (uri.compare(0, 5, "data:") == 0) {
    static const std::string mark = ";base64,";
    const std::size_t start = uri.find(mark);
    if (start == std::string::npos) fail("{}: only base64 data is read", where);
    return from_base64(uri.substr(start + mark.size()), where);
  }
  const std::string place = fmt::format("{} {}", where, in_quotes(uri));
  const std::optional<std::string> name = name_of_uri(uri);
  if (!name) fail("{}: expected the name of a file, relative to the model's folder", place);
  if (files.is_missing(*name)) fail("{}: there is no such file", place);
  const std::string* bytes = files.find({place, *name, expected});
  return bytes ? std::optional(*bytes) : std::nullopt;
}

std::string GltfSource::from_base64(const std::string& text, const std::string& where) const {
  static const std::string alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::size_t value = alphabet.find(c);
    if (value == std::string::npos) fail("{} is not base64", where);
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    held += 6;
    if (held >= 8) bytes += static_cast<char>(bits >> (held -= 8) & 0xff);
  }
  return bytes;
}

GltfAccessor GltfSource::accessor(const Json& value, const std::string& used_by) const {
  const std::size_t i = index(value, list("accessors").size(), used_by);
  const std::string where = fmt::format("accessors[{}]", i);
  const Json& in = item("accessors", i);
  if (in.contains("sparse")) fail("{} is sparse, which is not supported", where);
  if (!in.contains("bufferView")) fail("{} lacks bufferView", where);

  GltfAccessor a;
  a.component = whole(in, "componentType", where);
  if (a.component < 5120 || a.component > f32 || a.component == 5124)
    fail("{}.componentType {} is unknown", where, a.component);
  if (const auto type = in.find("type"); type != in.end() && type->is_string())
    a.type = type->get<std::string>();
  a.elements = elements_of(a.type);
  if (a.elements == 0) fail("{}.type is unknown", where);
  a.count = whole(in, "count", where);
  if (a.count == 0) fail("{} is empty", where);
  const auto normalized = in.find("normalized");
  a.normalized = normalized != in.end() && *normalized == true;

  const auto [start, length] = view(in["bufferView"], where + ".bufferView");
  const std::size_t v = in["bufferView"].get<std::size_t>();
  const std::string view_where = fmt::format("bufferViews[{}]", v);
  a.stride = whole(item("bufferViews", v), "byteStride", view_where, a.item_size());
  if (a.stride < a.item_size() || a.stride > 252) fail("{}.byteStride is wrong", view_where);
  const std::size_t offset = whole(in, "byteOffset", where, 0);
  if (offset + (a.count - 1) * a.stride + a.item_size() > length)
    fail("{} reaches beyond its bufferView", where);
  a.offset = start + offset;
  if (a.offset % size_of(a.component) != 0) fail("{} is not aligned", where);
  return a;
}

std::optional<std::string> GltfSource::image(std::size_t index, NamedFiles& files) const {
  const Json& in = item("images", index);
  const std::string where = fmt::format("images[{}]", index);
  if (const auto uri = in.find("uri"); uri != in.end()) {
    return from_uri(*uri, where + ".uri", "an image", files);
  }
  if (!in.contains("bufferView")) fail("{} has neither a uri nor a bufferView", where);
  const auto [start, length] = view(in["bufferView"], where + ".bufferView");
  return binary_.substr(start, length);
}

std::pair<std::size_t, std::size_t> GltfSource::view(const Json& value,
                                                     const std::string& used_by) const {
  const std::size_t v = index(value, list("bufferViews").size(), used_by);
  const std::string where = fmt::format("bufferViews[{}]", v);
  const Json& in = item("bufferViews", v);
  if (!in.contains("buffer")) fail("{} lacks buffer", where);
  const auto [start, size] = buffers_[index(in["buffer"], buffers_.size(), where + ".buffer")];
  const std::size_t offset = whole(in, "byteOffset", where, 0);
  const std::size_t length = whole(in, "byteLength", where);
  if (offset + length > size) fail("{} reaches beyond its buffer", where);
  return {start + offset, length};
}

std::uint32_t GltfSource::integer(const GltfAccessor& a, std::size_t item,
                                  std::size_t element) const {
  const std::size_t size = size_of(a.component);
  return little_endian(binary_, a.offset + item * a.stride + element * size, size);
}

float GltfSource::component(const GltfAccessor& a, std::size_t item, std::size_t element) const {
  const std::uint32_t bits = integer(a, item, element);
  const auto share = [&](auto value) {
    if (!a.normalized) return static_cast<float>(value);
    constexpr auto most = static_cast<float>(std::numeric_limits<decltype(value)>::max());
    return std::max(static_cast<float>(value) / most, -1.0f);
  };
  switch (a.component) {
    case i8:
      return share(static_cast<std::int8_t>(bits));
    case u8:
      return share(static_cast<std::uint8_t>(bits));
    case i16:
      return share(static_cast<std::int16_t>(bits));
    case u16:
      return share(static_cast<std::uint16_t>(bits));
    case u32:
      return share(bits);
    default:
      return std::bit_cast<float>(bits);
  }
}

// The textures of a glTF file.

/// The textures that materials name, decoded. All members throw BadAsset.
class GltfTextures {
 public:
  GltfTextures(const GltfSource& source, NamedFiles& files) : in_(source), files_(files) {}

  /// The index of the texture that `info` (glTF 2.0, section 5.28) names; -1 where it is left out,
  /// or its file has yet to come.
  int index_of(const Json& info, const std::string& where);

  std::vector<Texture> take() { return std::move(textures_); }
  /// What was left out, and where it is.
  const std::vector<std::pair<std::string, std::string>>& left_out() const { return left_out_; }

 private:
  static constexpr std::size_t kNoSampler = ~std::size_t{0};

  std::string name_of(std::size_t image) const;
  void set_sampler(std::size_t index, Texture& texture) const;

  const GltfSource& in_;
  NamedFiles& files_;
  std::vector<Texture> textures_;
  std::map<std::pair<std::size_t, std::size_t>, int> known_;  // by image and sampler
  std::vector<std::pair<std::string, std::string>> left_out_;
  std::size_t pixels_ = 0;
};

int GltfTextures::index_of(const Json& info, const std::string& where) {
  if (!info.is_object()) in_.fail("{} must be an object", where);
  const std::size_t t =
      in_.index(info.value("index", Json()), in_.list("textures").size(), where + ".index");
  const std::string place = fmt::format("textures[{}]", t);
  const Json& texture = in_.item("textures", t);
  if (!texture.contains("source")) {
    left_out_.emplace_back("textures other than PNG and JPEG", place);
    return -1;
  }
  const std::size_t image =
      in_.index(texture["source"], in_.list("images").size(), place + ".source");
  std::size_t sampler = kNoSampler;
  if (texture.contains("sampler")) {
    sampler = in_.index(texture["sampler"], in_.list("samplers").size(), place + ".sampler");
  }
  const auto known = known_.find({image, sampler});
  if (known != known_.end()) return known->second;
  const std::optional<std::string> bytes = in_.image(image, files_);
  if (!bytes) return -1;
  const std::string name = name_of(image);
  if (kind_of_image(*bytes) == ImageKind::other) {
    left_out_.emplace_back("textures other than PNG and JPEG", name);
    return known_[{image, sampler}] = -1;
  }
  Texture made;
  try {
    made = decode_image(*bytes, model_limits::pixels - pixels_);
  } catch (const std::runtime_error& error) {
    in_.fail("{}: {}", name, error.what());
  }
  pixels_ += std::size_t{made.width} * made.height;
  if (sampler != kNoSampler) set_sampler(sampler, made);
  textures_.push_back(std::move(made));
  return known_[{image, sampler}] = static_cast<int>(textures_.size()) - 1;
}

/// What messages call an image: its place, and its file's name.
std::string GltfTextures::name_of(std::size_t image) const {
  const std::string place = fmt::format("images[{}]", image);
  const Json& in = in_.item("images", image);
  const auto uri = in.find("uri");
  if (uri == in.end() || !uri->is_string()) return place;
  const auto& text = uri->get_ref<const std::string&>();
  return text.starts_with("data:") ? place : fmt::format("{} {}", place, in_quotes(text));
}

void GltfTextures::set_sampler(std::size_t index, Texture& texture) const {
  const std::string where = fmt::format("samplers[{}]", index);
  const Json& in = in_.item("samplers", index);
  const auto take = [&](const char* key, std::uint32_t& value,
                        std::initializer_list<std::uint32_t> known) {
    value = static_cast<std::uint32_t>(in_.whole(in, key, where, value));
    if (std::ranges::find(known, value) == known.end()) {
      in_.fail("{}.{} is {}, which is unknown", where, key, value);
    }
  };
  take("wrapS", texture.wrap_u, {10497, 33071, 33648});
  take("wrapT", texture.wrap_v, {10497, 33071, 33648});
  take("magFilter", texture.magnify, {9728, 9729});
  take("minFilter", texture.minify, {9728, 9729, 9984, 9985, 9986, 9987});
}

constexpr std::size_t triangles = 4, triangle_fan = 6;
constexpr std::size_t kNone = ~std::size_t{0};  // no index

void append32(std::string& bytes, std::size_t value) {
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

class Reduction {
 public:
  Reduction(const GltfSource& source, NamedFiles& files) : in_(source), textures_(source, files) {}

  CheckedGltf run() {
    const std::vector<std::size_t> roots = walk_nodes();
    note_left_out();
    for (std::size_t i = 0; i < in_.list("materials").size(); ++i) copy_material(i);
    copy_skins();
    for (std::size_t i = 0; i < in_.list("meshes").size(); ++i) copy_mesh(i);
    if (!out_.contains("meshes")) in_.fail("has no triangles");
    copy_animations();
    copy_nodes(roots);
    checked_.glb = pack();
    checked_.textures = textures_.take();
    for (const auto& [what, where] : textures_.left_out()) leave_out(what, where);
    for (const auto& [what, found] : left_out_) {
      checked_.left_out.push_back(
          found.count == 1 ? fmt::format("{} ({})", what, found.where)
                           : fmt::format("{} ({}, {} in all)", what, found.where, found.count));
    }
    return std::move(checked_);
  }

 private:
  struct Found {
    std::string where;  // the first of them
    std::size_t count = 0;
  };

  void leave_out(const std::string& what, const std::string& where) {
    Found& found = left_out_[what];
    if (found.count++ == 0) found.where = where;
  }

  void note_left_out() {
    for (std::size_t i = 0; i < in_.list("cameras").size(); ++i) {
      leave_out("cameras", fmt::format("cameras[{}]", i));
    }
    if (in_.list("scenes").size() > 1) leave_out("scenes but one", "scenes");
    for (const Json& name : in_.list("extensionsUsed")) {
      if (name.is_string() && is_supported_extension(name.get_ref<const std::string&>())) continue;
      leave_out(fmt::format("the extension {}", name.dump()), "extensionsUsed");
    }
  }

  /// Adds the accessor to the result, over a view of its own; its new index.
  std::size_t emit(const GltfAccessor& a) {
    const std::size_t item_size = a.item_size();
    Json view = {{"buffer", 0},
                 {"byteOffset", a.offset},
                 {"byteLength", (a.count - 1) * a.stride + item_size}};
    if (a.stride != item_size) view["byteStride"] = a.stride;
    out_["bufferViews"].push_back(view);
    Json accessor = {{"bufferView", out_["bufferViews"].size() - 1},
                     {"componentType", a.component},
                     {"count", a.count},
                     {"type", a.type}};
    if (a.normalized) accessor["normalized"] = true;
    out_["accessors"].push_back(accessor);
    return out_["accessors"].size() - 1;
  }

  /// Adds numbers of few bits as floats, behind all that the source holds; `change` may alter each
  /// item.
  template <typename Change>
  std::size_t emit_floats(const GltfAccessor& a, const Change& change) {
    const std::size_t start = begin_floats();
    std::vector<float> values(a.elements);
    for (std::size_t k = 0; k < a.count; ++k) {
      for (std::size_t e = 0; e < a.elements; ++e) values[e] = in_.component(a, k, e);
      change(values);
      for (const float value : values) append32(added_, std::bit_cast<std::uint32_t>(value));
    }
    return end_floats(start, a.count, a.elements, a.type);
  }
  std::size_t emit_floats(const GltfAccessor& a) {
    return emit_floats(a, [](std::vector<float>&) {});
  }

  /// Where floats that are added begin, in bytes.
  std::size_t begin_floats() {
    added_.resize((in_.binary().size() + added_.size() + 3) / 4 * 4 - in_.binary().size());
    return in_.binary().size() + added_.size();
  }
  std::size_t end_floats(std::size_t start, std::size_t count, std::size_t elements,
                         const std::string& type) {
    out_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", start}, {"byteLength", count * elements * sizeof(float)}});
    out_["accessors"].push_back({{"bufferView", out_["bufferViews"].size() - 1},
                                 {"componentType", f32},
                                 {"count", count},
                                 {"type", type}});
    return out_["accessors"].size() - 1;
  }

  // Nodes: a forest below the scene's roots.

  std::vector<std::size_t> walk_nodes() {
    const std::size_t count = in_.list("nodes").size();
    if (count > model_limits::nodes) in_.fail("more than {} nodes", model_limits::nodes);
    new_index_.assign(count, count);
    const std::vector<std::size_t> roots =
        in_.list("scenes").empty() ? nodes_without_parents() : nodes_of_scene();
    if (roots.empty()) in_.fail("its scene is empty");
    for (const std::size_t root : roots) visit(root, 0);
    return roots;
  }

  std::vector<std::size_t> nodes_of_scene() const {
    const std::size_t scene = in_.whole(in_.root(), "scene", "its JSON", 0);
    if (scene >= in_.list("scenes").size()) in_.fail("scene {} does not exist", scene);
    std::vector<std::size_t> roots;
    for (const Json& value : in_.list(in_.item("scenes", scene), "nodes", "its scene"))
      roots.push_back(in_.index(value, new_index_.size(), "a scene's node"));
    return roots;
  }

  /// What a file without any scene shows.
  std::vector<std::size_t> nodes_without_parents() const {
    const std::size_t count = new_index_.size();
    std::vector<bool> is_child(count, false);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string where = fmt::format("nodes[{}]", i);
      for (const Json& child : in_.list(in_.item("nodes", i), "children", where))
        is_child[in_.index(child, count, where + ".children")] = true;
    }
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < count; ++i)
      if (!is_child[i]) roots.push_back(i);
    return roots;
  }

  void visit(std::size_t node, std::size_t depth) {
    if (depth > model_limits::depth)
      in_.fail("nodes nested more than {} deep", model_limits::depth);
    const std::size_t count = new_index_.size();
    if (new_index_[node] != count) in_.fail("nodes[{}] has two parents", node);
    new_index_[node] = order_.size();
    order_.push_back(node);
    const std::string where = fmt::format("nodes[{}]", node);
    for (const Json& child : in_.list(in_.item("nodes", node), "children", where))
      visit(in_.index(child, count, where + ".children"), depth + 1);
  }

  /// Counts what a node shows of a mesh.
  std::size_t show(std::size_t mesh) {
    shown_ += out_["meshes"][new_mesh_[mesh]]["primitives"].size();
    if (shown_ > model_limits::meshes)
      in_.fail("its nodes show more than {} primitives", model_limits::meshes);
    return new_mesh_[mesh];
  }

  void copy_nodes(const std::vector<std::size_t>& roots) {
    std::set<std::string> names;
    for (const std::size_t i : order_) {
      const std::string where = fmt::format("nodes[{}]", i);
      const Json& in = in_.item("nodes", i);
      Json node = Json::object();
      for (const auto& [key, size] : {std::pair<const char*, std::size_t>{"translation", 3},
                                      {"rotation", 4},
                                      {"scale", 3},
                                      {"matrix", 16}}) {
        if (!in.contains(key)) continue;
        const Json& values = in_.list(in, key, where);
        if (values.size() != size) in_.fail("{}.{} must have {} numbers", where, key, size);
        double norm = 0;
        for (const Json& value : values) norm += std::pow(in_.number(value, where + "." + key), 2);
        if (size == 4 && std::abs(norm - 1) > 1e-3) in_.fail("{}.rotation is not a unit", where);
        node[key] = values;
      }
      const std::size_t mesh =
          in.contains("mesh") ? in_.index(in["mesh"], new_mesh_.size(), where + ".mesh") : kNone;
      const bool shows = mesh != kNone && new_mesh_[mesh] != kNone;
      if (shows) node["mesh"] = show(mesh);
      if (in.contains("skin")) {
        const std::size_t skin = in_.index(in["skin"], out_["skins"].size(), where + ".skin");
        if (shows) check_joints(mesh, node["skin"] = skin);
      }
      // Bones are found by name: the first node of a name keeps it, and no mesh takes a joint's.
      std::string unique = in_.name(in, fmt::format("node {}", i));
      if (in.contains("mesh") && !joints_.contains(i)) unique = "mesh:" + unique;
      if (!names.insert(unique).second) {
        names.insert(unique = fmt::format("{}#{}", unique, i));
      }
      node["name"] = unique;
      for (const Json& child : in_.list(in, "children", where))
        node["children"].push_back(new_index_[child.get<std::size_t>()]);
      checked_.nodes.push_back(unique);
      out_["nodes"].push_back(node);
    }
    Json scene = {{"nodes", Json::array()}};
    for (const std::size_t root : roots) scene["nodes"].push_back(new_index_[root]);
    out_["scenes"].push_back(scene);
    out_["scene"] = 0;
  }

  // Animations of nodes, which become bones.

  void copy_animations() {
    for (std::size_t i = 0; i < in_.list("animations").size(); ++i) {
      const std::string where = fmt::format("animations[{}]", i);
      const Json& in = in_.item("animations", i);
      Animation animation{in_.name(in, fmt::format("animation {}", i)), {}};
      for (const Json& channel : in_.list(in, "channels", where)) {
        if (!channel.is_object()) in_.fail("{}.channels must be objects", where);
        copy_channel(channel, in_.list(in, "samplers", where), where, animation);
      }
      if (!animation.tracks.empty()) checked_.animations.push_back(std::move(animation));
    }
  }

  void copy_channel(const Json& in, const Json& samplers, const std::string& where,
                    Animation& animation) {
    const Json target = in.value("target", Json::object());
    if (!target.is_object() || !target.contains("node")) return;  // of an extension
    const std::size_t node = in_.index(target["node"], new_index_.size(), where + " target.node");
    const std::string path = target.value("path", std::string());
    if (new_index_[node] == new_index_.size()) return;  // not in the scene
    if (path == "weights") return leave_out("movements of morph targets", where);
    const bool scales = path == "scale";
    if (path != "translation" && path != "rotation" && !scales)
      return leave_out("movements of another kind", where);

    const std::size_t sampler = in_.index(in.value("sampler", Json()), samplers.size(), where);
    if (!samplers[sampler].is_object()) in_.fail("{}.samplers must be objects", where);
    const std::string name = fmt::format("{}.samplers[{}]", where, sampler);
    const GltfAccessor input = in_.accessor(samplers[sampler].value("input", Json()), name),
                       output = in_.accessor(samplers[sampler].value("output", Json()), name);
    BoneTrack track;
    track.bone = static_cast<std::uint32_t>(new_index_[node]);
    track.of = path == "rotation" ? BoneTrack::Of::rotation : BoneTrack::Of::position;
    const std::string between = samplers[sampler].value("interpolation", std::string("LINEAR"));
    if (between == "STEP") track.between = BoneTrack::Between::step;
    if (between == "CUBICSPLINE") track.between = BoneTrack::Between::cubic;
    const std::size_t parts = track.between == BoneTrack::Between::cubic ? 3 : 1;
    if (input.type != "SCALAR" || output.elements != track.size() ||
        output.count != parts * input.count)
      in_.fail("{}: {} values of {} numbers at {} times", name, output.count, output.elements,
               input.count);
    keys_ += input.count + output.count * output.elements;
    if (keys_ > model_limits::keys)
      in_.fail("its animations have more than {} numbers", model_limits::keys);
    for (std::size_t k = 0; k < input.count; ++k) {
      track.times.push_back(double{in_.component(input, k, 0)});
      const bool rises = k == 0 || track.times[k] >= track.times[k - 1];
      if (!std::isfinite(track.times[k]) || !rises) in_.fail("{}: times must rise", name);
    }
    for (std::size_t k = 0; k < output.count; ++k)
      for (std::size_t e = 0; e < output.elements; ++e) {
        track.values.push_back(in_.component(output, k, e));
        if (!(std::abs(track.values.back()) < 1e9f)) in_.fail("{} is not finite", name);
      }
    if (scales) {
      for (std::size_t k = track.size(); k < track.values.size(); ++k)
        if (std::abs(track.values[k] - track.values[k % track.size()]) > 1e-3f)
          return leave_out("movements that scale", where);
      return;
    }
    joints_.insert(node);
    animation.tracks.push_back(std::move(track));
  }

  // Skins, meshes and materials.

  void copy_skins() {
    out_["skins"] = Json::array();
    for (std::size_t i = 0; i < in_.list("skins").size(); ++i) {
      const std::string where = fmt::format("skins[{}]", i);
      const Json& in = in_.item("skins", i);
      Json skin = {{"joints", Json::array()}};
      for (const Json& value : in_.list(in, "joints", where)) {
        const std::size_t joint = in_.index(value, new_index_.size(), where + ".joints");
        if (new_index_[joint] == new_index_.size()) in_.fail("{}.joints: not in the scene", where);
        joints_.insert(joint);
        skin["joints"].push_back(new_index_[joint]);
      }
      const std::size_t count = skin["joints"].size();
      if (count == 0 || count > model_limits::bones)
        in_.fail("{} has {} joints, expected 1 to {}", where, count, model_limits::bones);
      if (!in.contains("inverseBindMatrices")) {
        skin["inverseBindMatrices"] = emit_unit_matrices(count);
        out_["skins"].push_back(skin);
        continue;
      }
      const GltfAccessor a =
          in_.accessor(in["inverseBindMatrices"], where + ".inverseBindMatrices");
      if (a.type != "MAT4" || a.component != f32 || a.count != count)
        in_.fail("{}.inverseBindMatrices must be {} float matrices", where, count);
      skin["inverseBindMatrices"] = emit(a);
      out_["skins"].push_back(skin);
    }
  }

  std::size_t emit_unit_matrices(std::size_t count) {
    const std::size_t start = begin_floats();
    for (std::size_t i = 0; i < 16 * count; ++i)
      append32(added_, std::bit_cast<std::uint32_t>(i % 16 % 5 == 0 ? 1.0f : 0.0f));
    return end_floats(start, count, 16, "MAT4");
  }

  void check_joints(std::size_t mesh, std::size_t skin) const {
    if (highest_joint_[mesh] >= out_.at("skins")[skin]["joints"].size())
      in_.fail("meshes[{}] names joint {}, but its skin has {}", mesh, highest_joint_[mesh],
               out_.at("skins")[skin]["joints"].size());
  }

  void copy_mesh(std::size_t i) {
    const std::string where = fmt::format("meshes[{}]", i);
    const Json& in = in_.item("meshes", i);
    Json mesh = {{"name", in_.name(in, fmt::format("mesh {}", i))}, {"primitives", Json::array()}};
    highest_joint_.push_back(0);
    for (const Json& primitive : in_.list(in, "primitives", where)) {
      if (!primitive.is_object()) in_.fail("{}.primitives must be objects", where);
      if (++primitives_ > model_limits::meshes)
        in_.fail("more than {} primitives", model_limits::meshes);
      const std::size_t mode = in_.whole(primitive, "mode", where, triangles);
      if (mode > triangle_fan) in_.fail("{} has a primitive of mode {}", where, mode);
      if (mode < triangles) {
        leave_out("points and lines", where);
      } else {
        mesh["primitives"].push_back(copy_primitive(primitive, mode, where));
      }
    }
    if (in_.list(in, "primitives", where).empty()) in_.fail("{} has no primitives", where);
    new_mesh_.push_back(mesh["primitives"].empty() ? kNone : out_["meshes"].size());
    if (!mesh["primitives"].empty()) out_["meshes"].push_back(mesh);
  }

  Json copy_primitive(const Json& in, std::size_t mode, const std::string& where) {
    if (in.contains("targets")) leave_out("morph targets", where);
    Json out = {{"mode", mode}, {"attributes", Json::object()}};
    const auto attributes = in.find("attributes");
    if (attributes == in.end() || !attributes->is_object() || !attributes->contains("POSITION"))
      in_.fail("{} has a primitive without POSITION", where);
    const std::size_t count = in_.accessor((*attributes)["POSITION"], where + " POSITION").count;
    vertices_ += count;
    if (vertices_ > model_limits::vertices)
      in_.fail("more than {} vertices", model_limits::vertices);
    if (attributes->contains("JOINTS_1")) leave_out("all but four bones of each vertex", where);
    if (attributes->contains("JOINTS_0") != attributes->contains("WEIGHTS_0"))
      in_.fail("{} must have both JOINTS_0 and WEIGHTS_0, or neither", where);

    for (const char* key : {"POSITION", "NORMAL", "COLOR_0", "JOINTS_0", "WEIGHTS_0"}) {
      if (!attributes->contains(key)) continue;
      const std::string what = where + " " + key;
      const GltfAccessor a = in_.accessor((*attributes)[key], what);
      if (a.count != count) in_.fail("{} has {} items, but POSITION {}", what, a.count, count);
      const bool is_float = a.component == f32;
      const bool is_few_bits = a.component < u32;  // of positions and normals: quantized
      const bool is_unsigned = a.component == u8 || a.component == u16;
      bool fits = a.type == "VEC3" && (is_float || is_few_bits);
      if (key[0] == 'C')
        fits =
            (a.type == "VEC3" || a.type == "VEC4") && (is_float || (is_unsigned && a.normalized));
      if (key[0] == 'J') fits = a.type == "VEC4" && is_unsigned;
      if (key[0] == 'W') fits = a.type == "VEC4" && (is_float || (is_unsigned && a.normalized));
      if (!fits) in_.fail("{} of type {} {} is not read", what, a.type, a.component);
      if (key[0] == 'J') note_joints(a);
      const bool as_it_is = is_float || key[0] == 'C' || key[0] == 'J';
      out["attributes"][key] = as_it_is ? emit(a) : emit_floats(a);
    }
    if (in.contains("indices")) {
      const GltfAccessor a = in_.accessor(in["indices"], where + ".indices");
      if (a.type != "SCALAR" || a.component == f32 || a.component % 2 == 0)
        in_.fail("{}.indices must be unsigned integers", where);
      indices_ += a.count;
      if (indices_ > model_limits::indices) in_.fail("more than {} indices", model_limits::indices);
      for (std::size_t k = 0; k < a.count; ++k)
        if (in_.integer(a, k, 0) >= count)
          in_.fail("{} has index {}, but {} vertices", where, in_.integer(a, k, 0), count);
      out["indices"] = emit(a);
    }
    if (in.contains("material")) {
      const std::size_t material =
          in_.index(in["material"], in_.list("materials").size(), where + ".material");
      out["material"] = material;
      if (checked_.texture_of[material] >= 0)
        copy_coordinates(*attributes, base_texture_[material], count, where, out);
    }
    return out;
  }

  /// Where the vertices are on the texture of their material, as the only such set.
  void copy_coordinates(const Json& attributes, const Json& info, std::size_t count,
                        const std::string& where, Json& out) {
    const Json transform =
        info.value("extensions", Json::object()).value("KHR_texture_transform", Json::object());
    const std::size_t set = in_.whole(transform.contains("texCoord") ? transform : info, "texCoord",
                                      where + ".baseColorTexture", 0);
    const std::string key = fmt::format("TEXCOORD_{}", set), what = where + " " + key;
    if (!attributes.contains(key))
      return leave_out(fmt::format("a texture without {}", key), where);
    const GltfAccessor a = in_.accessor(attributes[key], what);
    if (a.count != count) in_.fail("{} has {} items, but POSITION {}", what, a.count, count);
    if (a.type != "VEC2" || a.component == u32)
      in_.fail("{} of type {} {} is not read", what, a.type, a.component);
    if (transform.empty()) {
      out["attributes"]["TEXCOORD_0"] = a.component == f32 ? emit(a) : emit_floats(a);
      return;
    }
    const auto pair = [&](const char* name, float fallback) {
      const Json& values = in_.list(transform, name, where);
      if (values.empty()) return std::array{fallback, fallback};
      if (values.size() != 2) in_.fail("{}: {} must have 2 numbers", where, name);
      return std::array{static_cast<float>(in_.number(values[0], name)),
                        static_cast<float>(in_.number(values[1], name))};
    };
    const auto offset = pair("offset", 0), scale = pair("scale", 1);
    const double turn =
        transform.contains("rotation") ? in_.number(transform["rotation"], "rotation") : 0;
    const auto c = static_cast<float>(std::cos(turn)), s = static_cast<float>(std::sin(turn));
    out["attributes"]["TEXCOORD_0"] = emit_floats(a, [&](std::vector<float>& uv) {
      const float u = uv[0] * scale[0], v = uv[1] * scale[1];
      uv = {c * u + s * v + offset[0], c * v - s * u + offset[1]};
    });
  }

  void note_joints(const GltfAccessor& a) {
    for (std::size_t k = 0; k < a.count; ++k)
      for (std::size_t e = 0; e < 4; ++e)
        highest_joint_.back() = std::max<std::size_t>(highest_joint_.back(), in_.integer(a, k, e));
  }

  void copy_material(std::size_t i) {
    const std::string where = fmt::format("materials[{}]", i);
    const Json& in = in_.item("materials", i);
    checked_.texture_of.push_back(-1);
    base_texture_.emplace_back();
    Json factors = Json::object();
    const auto color = [&](const Json& from, const char* key) {
      if (!from.contains(key)) return;
      const Json& values = in_.list(from, key, where);
      if (values.size() != 4) in_.fail("{}.{} must have 4 numbers", where, key);
      for (const Json& value : values) in_.number(value, where + "." + key);
      factors["baseColorFactor"] = values;
    };
    const auto texture = [&](const Json& from, const char* key) {
      if (!from.contains(key)) return;
      checked_.texture_of.back() = textures_.index_of(from[key], where + "." + key);
      base_texture_.back() = from[key];
    };
    const Json extensions = in.value("extensions", Json::object());
    const auto older = extensions.find("KHR_materials_pbrSpecularGlossiness");
    if (const auto pbr = in.find("pbrMetallicRoughness"); pbr != in.end() && pbr->is_object()) {
      color(*pbr, "baseColorFactor");
      texture(*pbr, "baseColorTexture");
      for (const char* key : {"metallicFactor", "roughnessFactor"})
        if (pbr->contains(key)) factors[key] = in_.number((*pbr)[key], where + "." + key);
      if (pbr->contains("metallicRoughnessTexture")) leave_out("metallicRoughnessTexture", where);
    } else if (older != extensions.end() && older->is_object()) {
      color(*older, "diffuseFactor");
      texture(*older, "diffuseTexture");
      factors["metallicFactor"] = 0;
      const char* key = "glossinessFactor";
      factors["roughnessFactor"] =
          older->contains(key) ? 1 - in_.number((*older)[key], where + "." + key) : 0;
      if (older->contains("specularGlossinessTexture"))
        leave_out("specularGlossinessTexture", where);
    }
    for (const char* key : {"normalTexture", "occlusionTexture", "emissiveTexture"})
      if (in.contains(key)) leave_out(key, where);
    if (const auto mode = in.find("alphaMode"); mode != in.end() && *mode != "OPAQUE")
      leave_out("transparency", where);
    for (const Json& light : in_.list(in, "emissiveFactor", where)) {
      if (in_.number(light, where + ".emissiveFactor") == 0) continue;
      leave_out("emitted light", where);
      break;
    }
    out_["materials"].push_back(
        {{"name", in_.name(in, fmt::format("material {}", i))}, {"pbrMetallicRoughness", factors}});
  }

  std::string pack() {
    out_["asset"] = {{"version", "2.0"}};
    const std::size_t size = in_.binary().size() + added_.size();
    out_["buffers"] = {{{"byteLength", size}}};
    if (in_.binary().empty()) in_.fail("holds no data");
    if (out_["skins"].empty()) out_.erase("skins");
    std::string text = out_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    append32(glb, 2);
    append32(glb, 12 + 8 + text.size() + 8 + size);
    append32(glb, text.size());
    glb += "JSON" + text;
    append32(glb, size);
    glb.append("BIN\0", 4);
    return glb + in_.binary() + added_;
  }

  const GltfSource& in_;
  CheckedGltf checked_;
  GltfTextures textures_;
  std::vector<Json> base_texture_;  // of each material: what names the texture of its colour
  Json out_;
  std::string added_;                   // to the source's data
  std::vector<std::size_t> new_index_;  // of a node, or the number of nodes: not in the scene
  std::vector<std::size_t> order_;      // nodes of the scene, parents first
  std::vector<std::size_t> new_mesh_;   // kNone: it has no triangles
  std::set<std::size_t> joints_;
  std::map<std::string, Found> left_out_;
  std::vector<std::size_t> highest_joint_;  // that a mesh names
  std::size_t vertices_ = 0, indices_ = 0, primitives_ = 0, keys_ = 0;
  std::size_t shown_ = 0;  // primitives, as often as nodes show them
};

}  // namespace

std::optional<CheckedGltf> checked_gltf(const std::filesystem::path& file,
                                        const std::string& content, NamedFiles& files) {
  try {
    const GltfSource source(file, content, files);
    if (!files.wanted().empty()) return {};
    CheckedGltf checked = Reduction(source, files).run();
    if (!files.wanted().empty()) return {};
    return checked;
  } catch (const Json::exception& error) {  // a value of another type than anything looks for
    throw bad_asset(file, error.what());
  }
}

}  // namespace taut::scenes
