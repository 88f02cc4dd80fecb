#include "scenes/model/gltf_textures.h"

#include <algorithm>
#include <initializer_list>
#include <stdexcept>

#include "scenes/model/image.h"
#include "scenes/model/limits.h"

namespace taut::scenes {

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

}  // namespace taut::scenes
