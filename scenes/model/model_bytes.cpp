#include "scenes/model/model_bytes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "scenes/model/model.h"

namespace taut::scenes {
namespace {

class Writer {
 public:
  explicit Writer(std::size_t size = 0) { bytes_.reserve(size); }

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

/// Counts the bytes that a Writer would write.
class Counter {
 public:
  template <typename T>
  bool plain(const T*, std::size_t count) {
    size_ += count * sizeof(T);
    return true;
  }
  template <typename List>
  bool count(const List&, std::size_t) {
    size_ += sizeof(std::uint64_t);
    return true;
  }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
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
  return pass_list(bytes, material.name) && bytes.plain(&material.texture, 1) &&
         bytes.plain(&material.base_color, 1) && bytes.plain(&material.roughness, 1) &&
         bytes.plain(&material.metallic, 1);
}

template <typename Bytes, typename Kept>
bool pass_texture(Bytes& bytes, Kept& texture) {
  return bytes.plain(&texture.width, 1) && bytes.plain(&texture.height, 1) &&
         bytes.plain(&texture.wrap_u, 1) && bytes.plain(&texture.wrap_v, 1) &&
         bytes.plain(&texture.magnify, 1) && bytes.plain(&texture.minify, 1) &&
         pass_list(bytes, texture.pixels);
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
bool pass_each(Bytes& bytes, Kept& list, const auto& pass_one) {
  constexpr std::size_t empty_name = sizeof(std::uint64_t);
  return bytes.count(list, empty_name) &&
         std::ranges::all_of(list, [&](auto& one) { return pass_one(bytes, one); });
}

template <typename Bytes, typename Kept>
bool pass_track(Bytes& bytes, Kept& track) {
  return bytes.plain(&track.bone, 1) && bytes.plain(&track.of, 1) &&
         bytes.plain(&track.between, 1) && pass_list(bytes, track.times) &&
         pass_list(bytes, track.values);
}

template <typename Bytes, typename Kept>
bool pass_animation(Bytes& bytes, Kept& animation) {
  return pass_list(bytes, animation.name) &&
         pass_each(bytes, animation.tracks, [](auto& b, auto& m) { return pass_track(b, m); });
}

template <typename Bytes, typename Kept>
bool pass(Bytes& bytes, Kept& model) {
  const auto each = [&](auto& list, const auto& pass_one) {
    return pass_each(bytes, list, pass_one);
  };
  return pass_list(bytes, model.name) &&
         each(model.textures, [](auto& b, auto& m) { return pass_texture(b, m); }) &&
         each(model.materials, [](auto& b, auto& m) { return pass_material(b, m); }) &&
         each(model.meshes, [](auto& b, auto& m) { return pass_mesh(b, m); }) &&
         each(model.bones, [](auto& b, auto& m) { return pass_bone(b, m); }) &&
         each(model.animations, [](auto& b, auto& m) { return pass_animation(b, m); }) &&
         each(model.left_out, [](auto& b, auto& m) { return pass_list(b, m); });
}

template <typename Bytes, typename Kept>
bool pass_files(Bytes& bytes, Kept& files) {
  return bytes.count(files, 3 * sizeof(std::uint64_t)) && std::ranges::all_of(files, [&](auto& f) {
           return pass_list(bytes, f.where) && pass_list(bytes, f.name) &&
                  pass_list(bytes, f.expected);
         });
}

bool is_finite(const auto& numbers) {
  return std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); });
}

bool is_sound(const Vertex& vertex, std::size_t bones) {
  const bool skinned = std::ranges::any_of(vertex.weights, [](float x) { return x != 0; });
  return is_finite(vertex.position) && is_finite(vertex.normal) && is_finite(vertex.color) &&
         is_finite(vertex.uv) && is_finite(vertex.weights) &&
         (!skinned || std::ranges::all_of(vertex.bones, [&](auto b) { return b < bones; }));
}

bool is_sound(const Texture& texture) {
  const auto wraps = [](std::uint32_t how) {
    return how == 10497 || how == 33071 || how == 33648;  // repeated, clamped, mirrored
  };
  const std::uint32_t small = texture.minify, large = texture.magnify;
  return texture.width > 0 && texture.height > 0 &&
         texture.pixels.size() == std::size_t{4} * texture.width * texture.height &&
         wraps(texture.wrap_u) && wraps(texture.wrap_v) && (large == 9728 || large == 9729) &&
         (small == 9728 || small == 9729 || (small >= 9984 && small <= 9987));
}

bool is_sound(const BoneTrack& track, std::size_t bones) {
  const std::size_t parts = track.between == BoneTrack::Between::cubic ? 3 : 1;
  return track.bone < bones && track.of <= BoneTrack::Of::rotation &&
         track.between <= BoneTrack::Between::cubic && !track.times.empty() &&
         track.values.size() == track.times.size() * track.size() * parts &&
         std::ranges::all_of(track.times, [](double t) { return std::isfinite(t); }) &&
         std::ranges::is_sorted(track.times) && is_finite(track.values);
}

bool is_sound(const Model& model) {
  const auto texture = [](const Texture& t) { return is_sound(t); };
  const auto material = [&](const Material& m) {
    return m.texture >= -1 && m.texture < std::ssize(model.textures) && is_finite(m.base_color) &&
           std::isfinite(m.roughness) && std::isfinite(m.metallic);
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
  const auto animation = [&](const Animation& a) {
    return std::ranges::all_of(
        a.tracks, [&](const BoneTrack& track) { return is_sound(track, model.bones.size()); });
  };
  return std::ranges::all_of(model.animations, animation) &&
         model.bones.size() <= model_limits::bones && std::ranges::all_of(model.bones, bone) &&
         std::ranges::all_of(model.textures, texture) &&
         std::ranges::all_of(model.materials, material) && std::ranges::all_of(model.meshes, mesh);
}

}  // namespace

std::string to_bytes(const Model& model) {
  Counter counter;
  pass(counter, model);
  Writer writer(counter.size());
  pass(writer, model);
  return writer.take();
}

std::optional<Model> model_of_bytes(std::string_view bytes) {
  Reader reader(bytes);
  Model model;
  if (!pass(reader, model) || !reader.at_end() || !is_sound(model)) return {};
  return model;
}

std::string to_bytes(const std::vector<NamedFile>& files) {
  Writer writer;
  pass_files(writer, files);
  return writer.take();
}

std::optional<std::vector<NamedFile>> named_files_of_bytes(std::string_view bytes) {
  Reader reader(bytes);
  std::vector<NamedFile> files;
  if (!pass_files(reader, files) || !reader.at_end()) return {};
  return files;
}

}  // namespace taut::scenes
