// The materials of an OBJ file's libraries of materials.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/model/imported.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// The name of a file as OBJ files write it, with slashes; nothing where it starts from a root or a
/// drive.
std::optional<std::string> name_of_path(std::string_view written);

/// Gathers colours, roughness and metal (Kd, Pr, Pm) as a library that is proved to be sound, and
/// the pictures of colours (map_Kd). All members throw BadAsset.
class ObjMaterials {
 public:
  ObjMaterials(const std::filesystem::path& file, NamedFiles& files) : file_(file), files_(files) {}

  /// Reads a library, of that name, relative to the model's folder.
  void add(const std::string& library, std::string_view text);

  Textures take() { return std::move(textures_); }
  const std::string& text() const { return text_; }                       // the sound library
  const std::vector<std::string>& left_out() const { return left_out_; }  // a line each

 private:
  void add_numbers(const std::vector<std::string_view>& words, const std::string& where);
  void add_picture(const std::string& library, const std::vector<std::string_view>& words,
                   const std::string& material, const std::string& where);

  const std::filesystem::path& file_;
  NamedFiles& files_;
  std::string text_;
  std::size_t materials_ = 0;
  Textures textures_;
  std::map<std::string, int> known_;  // by the picture's name
  std::vector<std::string> left_out_;
  std::size_t pixels_ = 0;
};

}  // namespace taut::scenes
