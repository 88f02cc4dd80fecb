// A binary glTF file in the making: JSON, and the numbers that it speaks of.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "render/export/frame_writer.h"
#include "sim/motion/types.h"

namespace taut::exporting {

class GltfFile {
 public:
  using Json = nlohmann::ordered_json;

  /// The numbers of components, as glTF 2.0, section 3.6.2.2 has them.
  enum Component : int { u8 = 5121, i16 = 5122, u16 = 5123, u32 = 5125, f32 = 5126 };
  enum class Use { animation, vertices, indices };

  /// Adds an object to one of the file's lists; its index there.
  std::size_t add(const char* list, Json object);
  Json& object(const char* list, std::size_t index) { return root_[list][index]; }

  struct Numbers {
    Component component;
    const char* type;  // as in "VEC3"
    Use use = Use::animation;
    bool normalized = false;
    bool bounds = false;  // whether the file says their least and largest, floats alone
  };
  /// Adds an accessor of all these numbers; its index. The items are as many bytes apart as they
  /// have.
  template <typename Number>
  std::size_t add_numbers(std::span<const Number> numbers, const Numbers& about) {
    const Json bounds = about.bounds ? bounds_of(numbers, about.type) : Json();
    return add_bytes({reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()},
                     sizeof(Number), about, bounds);
  }

  void name_scene(const std::string& name) { root_["scenes"][0]["name"] = name; }
  void use_extension(const char* name, Json said) {
    root_["extensionsUsed"].push_back(name);
    Json& extensions = root_["extensions"];
    if (extensions.is_null()) extensions = Json::object();
    extensions[name] = std::move(said);
  }

  /// The node's index. Without a parent it is a root of the scene.
  std::size_t add_node(const std::string& name, std::optional<std::size_t> parent = {});
  Json& node(std::size_t index) { return root_["nodes"][index]; }
  /// Places a node that does not move.
  void place(std::size_t node, const Pose& pose);

  /// Writes all of it. Nothing can be added then.
  void write(const WriteBytes& write);

 private:
  static Json& list_in(Json& object, const char* name);
  template <typename Number>
  static Json bounds_of(std::span<const Number> numbers, std::string_view type);
  std::size_t add_bytes(std::string_view bytes, std::size_t component_size, const Numbers& about,
                        const Json& bounds);

  Json root_ = {{"asset", {{"version", "2.0"}, {"generator", "taut"}}},
                {"extensionsUsed", Json::array()},
                {"scene", 0},
                {"scenes", {{{"nodes", Json::array()}}}}};
  std::string bytes_;
};

/// How many numbers an item of that type has.
std::size_t components_of(std::string_view type);

template <typename Number>
GltfFile::Json GltfFile::bounds_of(std::span<const Number> numbers, std::string_view type) {
  const std::size_t size = components_of(type);
  std::vector<Number> least(numbers.begin(), numbers.begin() + std::ptrdiff_t(size)),
      largest = least;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    least[i % size] = std::min(least[i % size], numbers[i]);
    largest[i % size] = std::max(largest[i % size], numbers[i]);
  }
  return {{"min", least}, {"max", largest}};
}

}  // namespace taut::exporting
