#include "scenes/model/gltf_source.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "scenes/model/limits.h"
#include "sim/motion/printable.h"

namespace taut::scenes {
namespace {

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

}  // namespace

std::size_t GltfAccessor::item_size() const {
  return elements * size_of(component);
}

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

}  // namespace taut::scenes
