#include "scenes/model/obj_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <stdexcept>

#include "scenes/files/regular_file.h"
#include "scenes/model/image.h"
#include "scenes/model/limits.h"
#include "scenes/model/obj_text.h"

namespace taut::scenes {
namespace {

/// How many words follow an option of a picture at most; numbers may be fewer.
const std::map<std::string_view, std::size_t> kOptions = {
    {"-blendu", 1}, {"-blendv", 1},  {"-bm", 1},  {"-boost", 1}, {"-cc", 1},
    {"-clamp", 1},  {"-imfchan", 1}, {"-mm", 2},  {"-o", 3},     {"-s", 3},
    {"-t", 3},      {"-texres", 1},  {"-type", 1}};

bool is_number(std::string_view word) {
  return word.find_first_not_of("0123456789+-.eE") == word.npos;
}

/// The first word that belongs to no option.
std::size_t after_options(const std::vector<std::string_view>& words, std::size_t at) {
  while (at < words.size()) {
    const auto option = kOptions.find(words[at]);
    if (option == kOptions.end()) break;
    const std::size_t end = at + 1 + option->second;
    ++at;
    const bool numbers = option->second > 1;
    while (at < std::min(end, words.size()) && (!numbers || is_number(words[at]))) ++at;
  }
  return at;
}

}  // namespace

std::optional<std::string> name_of_path(std::string_view written) {
  std::string name(written);
  std::ranges::replace(name, '\\', '/');
  const bool drive = name.size() > 1 && name[1] == ':';
  if (name.empty() || name[0] == '/' || drive || name.find('\0') != name.npos) return {};
  return name;
}

void ObjMaterials::add(const std::string& library, std::string_view text) {
  static const std::set<std::string_view> others = {
      "map_Ka",   "map_Ks", "map_Ke", "map_Ns", "map_d", "map_Pr", "map_Pm", "map_Ps", "map_Bump",
      "map_bump", "bump",   "disp",   "decal",  "refl",  "norm",   "map_Kn", "map_Tr", "map_refl"};
  std::string material;
  bool named = false;
  std::map<std::string_view, std::size_t> left;
  ObjLines lines(text);
  for (std::string line; lines.next(line);) {
    if (line.find('\0') != line.npos) {
      throw bad_asset(file_, fmt::format("{}: not a text file", in_quotes(library)));
    }
    const auto words = words_of(line);
    if (words.size() < 2) continue;
    const std::string where = fmt::format("{}: line {}: {}", library, lines.number(), words[0]);
    if (words[0] == "newmtl") {
      if (++materials_ > model_limits::meshes) {
        throw bad_asset(file_, fmt::format("{}: more than {}", where, model_limits::meshes));
      }
      material = words_from(words, 1);
      named = true;
      text_ += fmt::format("newmtl {}\n", material);
    }
    if (!named) continue;
    if (words[0] == "Kd" || words[0] == "Pr" || words[0] == "Pm") add_numbers(words, where);
    if (words[0] == "map_Kd") add_picture(library, words, material, where);
    if (const auto other = others.find(words[0]); other != others.end()) ++left[*other];
    if (words[0] == "d" && words[1] != "1" && !words[1].starts_with("1.")) ++left["d"];
  }
  for (const auto& [word, count] : left) {
    left_out_.push_back(fmt::format("{} ({}, {} of them)", word, library, count));
  }
}

void ObjMaterials::add_numbers(const std::vector<std::string_view>& words,
                               const std::string& where) {
  if (words[1] == "spectral" || words[1] == "xyz") {
    left_out_.push_back(fmt::format("a colour that is not red, green and blue ({})", where));
    return;
  }
  std::string line(words[0]);
  const std::size_t count = words[0] == "Kd" ? 3 : 1;
  for (std::size_t i = 1; i <= count; ++i) {
    const std::string_view word = words[i < words.size() ? i : 1];  // one number is a grey
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() ||
        !(value >= 0 && value <= 1e3f)) {
      throw bad_asset(file_, fmt::format("{}: \"{}\" is not a number from 0", where, word));
    }
    line += fmt::format(" {}", value);
  }
  text_ += line + '\n';
}

void ObjMaterials::add_picture(const std::string& library,
                               const std::vector<std::string_view>& words,
                               const std::string& material, const std::string& where) {
  const std::size_t first = after_options(words, 1);
  if (first > 1) left_out_.push_back(fmt::format("options of pictures ({})", where));
  if (first >= words.size()) return;
  const std::string place = fmt::format("{} {}", where, in_quotes(words_from(words, first)));
  const auto written = name_of_path(words_from(words, first));
  if (!written) {
    throw bad_asset(
        file_, fmt::format("{}: expected the name of a file, relative to the library's", place));
  }
  const std::string name = (std::filesystem::path(library).parent_path() / *written).string();
  const auto known = known_.find(name);
  if (known != known_.end()) {
    if (known->second >= 0) textures_.of_name[material] = known->second;
    return;
  }
  if (files_.is_missing(name)) {
    left_out_.push_back(fmt::format("{}: there is no such file", place));
    return;
  }
  const std::string* bytes = files_.find({place, name, "an image"});
  if (!bytes) return;
  known_[name] = -1;
  if (kind_of_image(*bytes) == ImageKind::other) {
    left_out_.push_back(fmt::format("textures other than PNG and JPEG ({})", place));
    return;
  }
  try {
    Texture made = decode_image(*bytes, model_limits::pixels - pixels_);
    pixels_ += std::size_t{made.width} * made.height;
    textures_.all.push_back(std::move(made));
  } catch (const std::runtime_error& error) {
    throw bad_asset(file_, fmt::format("{}: {}", place, error.what()));
  }
  textures_.of_name[material] = known_[name] = static_cast<int>(textures_.all.size()) - 1;
}

}  // namespace taut::scenes
