#include "scenes/model/model_bytes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "scenes/model/limits.h"

namespace taut::scenes {
namespace {

class Writer {
 public:
  template <typename T>
  bool plain(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(values), count * sizeof(T));
    return true;
  }
  template <typename List>
  bool count(const List& list, std::size_t) {
    const std::uint64_t size = list.size();
    return plain(&size, 1);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  bool plain(T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > bytes_.size() / sizeof(T)) return false;
    if (count > 0) std::memcpy(values, bytes_.data(), count * sizeof(T));
    bytes_.remove_prefix(count * sizeof(T));
    return true;
  }
  /// Elements take so many bytes `each` at least: no count asks for more memory than came.
  template <typename List>
  bool count(List& list, std::size_t each) {
    std::uint64_t size = 0;
    if (!plain(&size, 1) || size > bytes_.size() / each) return false;
    list.resize(size);
    return true;
  }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

// Reading and writing share this order. `Kept` is a part of a model, const where it is written.

template <typename Bytes, typename Kept>
bool pass_list(Bytes& bytes, Kept& list) {
  return bytes.count(list, sizeof *list.data()) && bytes.plain(list.data(), list.size());
}

template <typename Bytes, typename Kept>
bool pass_material(Bytes& bytes, Kept& material) {
  return pass_list(bytes, material.name) && bytes.plain(&material.base_color, 1) &&
         bytes.plain(&material.roughness, 1) && bytes.plain(&material.metallic, 1);
}

template <typename Bytes, typename Kept>
bool pass_mesh(Bytes& bytes, Kept& mesh) {
  return pass_list(bytes, mesh.name) && bytes.plain(&mesh.material, 1) &&
         pass_list(bytes, mesh.vertices) && pass_list(bytes, mesh.indices);
}

template <typename Bytes, typename Kept>
bool pass_bone(Bytes& bytes, Kept& bone) {
  return pass_list(bytes, bone.name) && bytes.plain(&bone.parent, 1) &&
         bytes.plain(bone.rest.position.data(), 3) &&
         bytes.plain(bone.rest.rotation.coeffs().data(), 4) &&
         bytes.plain(bone.inverse_bind.data(), 16);
}

template <typename Bytes, typename Kept>
bool pass(Bytes& bytes, Kept& model) {
  const auto each = [&](auto& list, const auto& pass_one) {
    constexpr std::size_t empty_name = sizeof(std::uint64_t);
    return bytes.count(list, empty_name) &&
           std::ranges::all_of(list, [&](auto& one) { return pass_one(bytes, one); });
  };
  return pass_list(bytes, model.name) &&
         each(model.materials, [](auto& b, auto& m) { return pass_material(b, m); }) &&
         each(model.meshes, [](auto& b, auto& m) { return pass_mesh(b, m); }) &&
         each(model.bones, [](auto& b, auto& m) { return pass_bone(b, m); });
}

bool is_finite(const auto& numbers) {
  return std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); });
}

bool is_sound(const Vertex& vertex, std::size_t bones) {
  const bool skinned = std::ranges::any_of(vertex.weights, [](float x) { return x != 0; });
  return is_finite(vertex.position) && is_finite(vertex.normal) && is_finite(vertex.color) &&
         is_finite(vertex.weights) &&
         (!skinned || std::ranges::all_of(vertex.bones, [&](auto b) { return b < bones; }));
}

bool is_sound(const Model& model) {
  const auto material = [](const Material& m) {
    return is_finite(m.base_color) && std::isfinite(m.roughness) && std::isfinite(m.metallic);
  };
  const auto mesh = [&](const Mesh& m) {
    return m.material < model.materials.size() &&
           std::ranges::all_of(m.indices, [&](auto i) { return i < m.vertices.size(); }) &&
           std::ranges::all_of(m.vertices,
                               [&](const Vertex& v) { return is_sound(v, model.bones.size()); });
  };
  const auto bone = [&](const Bone& b) {
    return b.parent >= -1 && b.parent < &b - model.bones.data() && b.rest.position.allFinite() &&
           b.rest.rotation.coeffs().allFinite() && b.inverse_bind.allFinite();
  };
  return model.bones.size() <= model_limits::bones && std::ranges::all_of(model.bones, bone) &&
         std::ranges::all_of(model.materials, material) && std::ranges::all_of(model.meshes, mesh);
}

}  // namespace

std::string to_bytes(const Model& model) {
  Writer writer;
  pass(writer, model);
  return writer.take();
}

std::optional<Model> model_of_bytes(std::string_view bytes) {
  Reader reader(bytes);
  Model model;
  if (!pass(reader, model) || !reader.at_end() || !is_sound(model)) return {};
  return model;
}

}  // namespace taut::scenes
