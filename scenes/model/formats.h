// Readers of each format of models, for import.cpp.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/model/model.h"
#include "scenes/model/named_files.h"

namespace taut::scenes {

/// Textures, and the texture of each material's colour.
struct Textures {
  std::vector<Texture> all;
  std::vector<int> of_material;        // by the material's index; -1: none
  std::map<std::string, int> of_name;  // by its name
};

/// Animations, whose bones are indices into the names of nodes.
struct NodeAnimations {
  std::vector<Animation> all;
  std::vector<std::string> nodes;
};

// BVH files: motion capture without a body.

/// The skeleton, with a rod from each joint to the next as its mesh. Its motion is the one
/// animation, called "motion". Lengths are those of the file, which states no unit. Throws
/// BadAsset.
Model read_bvh(const std::filesystem::path& file, const std::string& content);

/// A glTF file, checked and reduced to what a model uses.
struct CheckedGltf {
  std::string glb;
  std::vector<Texture> textures;
  std::vector<int> texture_of;        // for each material the texture of its colour, or -1
  std::vector<Animation> animations;  // their bones are indices into `nodes`
  std::vector<std::string> nodes;     // names in the GLB
  std::vector<std::string> left_out;  // a line for each thing left out
};

/// Checks that every offset, count and index in `content`, a .glb or .gltf file, is in range, so
/// that the importer can trust them. The result is one self-contained GLB of triangles, skins,
/// nodes, material factors, texture coordinates and animations. Buffers that the file names come
/// from `files`; none while `files` lacks one. Throws BadAsset.
std::optional<CheckedGltf> checked_gltf(const std::filesystem::path& file,
                                        const std::string& content, NamedFiles& files);

/// A Wavefront OBJ file of polygons, groups and materials only, with all numbers and indices
/// checked.
struct CheckedObj {
  std::string text;
  std::string materials;              // of all its libraries
  Textures textures;                  // by the names of materials
  std::vector<std::string> left_out;  // a sentence for each thing
};

/// Checks `content`, an OBJ file. Its libraries of materials come from `files`; none while `files`
/// lacks one. Lines and curves are left out. Throws BadAsset, which names the line, for unknown
/// statements, broken numbers, and faces whose vertices do not exist.
std::optional<CheckedObj> checked_obj(const std::filesystem::path& file, const std::string& content,
                                      NamedFiles& files);

/// The name of a file as OBJ files write it, with slashes; none if it starts from a root or a
/// drive.
std::optional<std::string> name_of_path(std::string_view written);

/// The materials of an OBJ file: colours, roughness and metal (Kd, Pr, Pm) as one checked library,
/// and the pictures of colours (map_Kd). All members throw BadAsset.
class ObjMaterials {
 public:
  ObjMaterials(const std::filesystem::path& file, NamedFiles& files) : file_(file), files_(files) {}

  /// Reads a library; its name is relative to the model's folder.
  void add(const std::string& library, std::string_view text);

  Textures take() { return std::move(textures_); }
  const std::string& text() const { return text_; }                       // the checked library
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

enum class ImageKind { png, jpeg, other };
ImageKind kind_of_image(std::string_view bytes);

/// Decodes a PNG or JPEG file. Throws std::runtime_error with the cause if it is broken, has more
/// than `most` pixels, or has colours that are not supported (CMYK).
Texture decode_image(std::string_view bytes, std::size_t most);

}  // namespace taut::scenes
