// The animation of a glTF file: channels over one list of keys, or over their own part of it.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "render/export/gltf/gltf_file.h"

namespace taut::exporting {

class GltfMotion {
 public:
  explicit GltfMotion(GltfFile& file) : file_(file) {}

  /// The node's own place is that of a joint as its mesh was made, and stays in the file.
  void keep(std::size_t node) { joints_.insert(node); }

  /// Where a node is at the next key, against its parent; straight between keys. Of each node at
  /// every key or never. Rotations are kept in 16 bits a number, to 6e-5 rad.
  void translate(std::size_t node, const Vec3& to);
  void turn(std::size_t node, const Quat& to);

  /// The same for all keys at once as cubic splines: slope before, value, slope behind.
  void spline_translation(std::size_t node, const std::vector<float>& numbers);
  void spline_rotation(std::size_t node, const std::vector<float>& numbers);

  /// Adds the animation to the file. A constant value becomes its node's place instead, unless that
  /// is kept. Nothing can be added then.
  void finish(const std::string& name, const std::vector<float>& times);

 private:
  void spline(std::size_t node, const char* path, std::size_t size,
              const std::vector<float>& numbers);
  /// A track of so many components an item, over the keys that it needs to be off by `most` at
  /// most, where that takes less room.
  template <typename Number>
  void straight(std::size_t node, const char* path, const GltfFile::Numbers& about,
                std::size_t size, double most, const std::vector<Number>& track,
                const std::vector<float>& times);
  /// A track of one key.
  template <typename Number>
  void still(std::size_t node, const char* path, const GltfFile::Numbers& about,
             std::span<const Number> value);
  std::size_t input(const std::vector<float>& times);
  void channel(std::size_t node, const char* path, const char* interpolation, std::size_t output);

  struct Spline {
    std::size_t node;
    const char* path;
    std::vector<float> numbers;
  };
  GltfFile& file_;
  std::map<std::size_t, std::vector<float>> translations_;
  std::map<std::size_t, std::vector<std::int16_t>> rotations_;
  std::set<std::size_t> joints_;      // whose places are kept
  std::optional<std::size_t> start_;  // the accessor of a list of one key
  GltfFile::Json channels_ = GltfFile::Json::array(), samplers_ = GltfFile::Json::array();
};

}  // namespace taut::exporting
