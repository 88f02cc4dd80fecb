// The textures of a glTF file.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scenes/model/gltf_source.h"
#include "scenes/model/model.h"

namespace taut::scenes {

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

}  // namespace taut::scenes
