#include "render/export/gltf/gltf_file.h"

#include "render/export/npz.h"

namespace taut::exporting {
namespace {

constexpr std::uint32_t kMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

void pad(std::string& bytes, char with) {
  bytes.append((4 - bytes.size() % 4) % 4, with);
}

}  // namespace

std::size_t components_of(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "MAT4") return 16;
  return std::size_t(type.back() - '0');
}

/// The list of that name, which is made where there is none. A null that push_back() turns into a
/// list is left broken where memory runs out.
GltfFile::Json& GltfFile::list_in(Json& object, const char* name) {
  Json& list = object[name];
  if (list.is_null()) list = Json::array();
  return list;
}

std::size_t GltfFile::add(const char* list, Json object) {
  list_in(root_, list).push_back(std::move(object));
  return root_[list].size() - 1;
}

std::size_t GltfFile::add_bytes(std::string_view bytes, std::size_t component_size,
                                const Numbers& about, const Json& bounds) {
  pad(bytes_, 0);
  Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (about.use != Use::animation) view["target"] = about.use == Use::vertices ? 34962 : 34963;
  bytes_ += bytes;
  Json accessor = {{"bufferView", add("bufferViews", std::move(view))},
                   {"componentType", int(about.component)},
                   {"count", bytes.size() / component_size / components_of(about.type)},
                   {"type", about.type}};
  if (about.normalized) accessor["normalized"] = true;
  if (!bounds.is_null()) accessor.update(bounds);
  return add("accessors", std::move(accessor));
}

std::size_t GltfFile::add_node(const std::string& name, std::optional<std::size_t> parent) {
  const std::size_t index = add("nodes", {{"name", name}});
  if (parent) {
    list_in(node(*parent), "children").push_back(index);
  } else {
    root_["scenes"][0]["nodes"].push_back(index);
  }
  return index;
}

void GltfFile::place(std::size_t index, const Pose& pose) {
  const Quat q = pose.rotation.normalized();
  const Vec3& p = pose.position;
  if (!p.isZero(0)) node(index)["translation"] = {float(p.x()), float(p.y()), float(p.z())};
  if (q.w() < 1) node(index)["rotation"] = {float(q.x()), float(q.y()), float(q.z()), float(q.w())};
}

void GltfFile::write(const WriteBytes& write) {
  pad(bytes_, 0);
  if (!bytes_.empty()) root_["buffers"] = {{{"byteLength", bytes_.size()}}};
  if (root_["extensionsUsed"].empty()) root_.erase("extensionsUsed");
  std::string json = root_.dump();
  pad(json, ' ');
  const auto size = [](const std::string& chunk) { return std::uint32_t(chunk.size()); };
  write(little_endian(kMagic, std::uint32_t(2),
                      std::uint32_t(12 + 8 + size(json) + 8 + size(bytes_)), size(json),
                      kJsonChunk) +
        json + little_endian(size(bytes_), kBinaryChunk));
  write(bytes_);
}

}  // namespace taut::exporting
