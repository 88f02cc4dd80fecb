// A model: meshes, materials, a skeleton and animations as plain data, whatever file they came
// from; and the limits of models.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/motion/types.h"

namespace taut::scenes {

/// A picture on a surface, and how it is looked up: by glTF's numbers (2.0, section 5.26), which
/// are those of OpenGL.
struct Texture {
  std::uint32_t width = 0, height = 0;
  std::uint32_t wrap_u = 10497, wrap_v = 10497;  // beyond its edges: repeated
  std::uint32_t magnify = 9729, minify = 9987;   // linear; means of it, and between them
  std::vector<std::uint8_t> pixels;              // sRGB and opacity, 4 bytes, rows from the top
};

/// Surface of a mesh; physically based, linear colours.
struct Material {
  std::string name;
  std::array<float, 3> base_color{0.8f, 0.8f, 0.8f};
  float roughness = 0.6f;
  float metallic = 0;
  int texture = -1;  // index into Model::textures; its colours multiply base_color; -1: none
};

/// One vertex: bind-pose position (m), normal, linear colour that multiplies the material's, and up
/// to four bones with weights that sum to 1 (all zero: not skinned).
struct Vertex {
  std::array<float, 3> position{};
  std::array<float, 3> normal{};
  std::array<float, 3> color{1, 1, 1};
  std::array<float, 2> uv{};  // of the material's texture, from its top left corner
  std::array<std::uint16_t, 4> bones{};
  std::array<float, 4> weights{};
};

struct Mesh {
  std::string name;
  std::size_t material = 0;  // index into Model::materials
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles
};

/// A joint of the skeleton; parents stand before their children.
struct Bone {
  std::string name;
  int parent = -1;
  Pose rest;                                                   // relative to its parent
  Eigen::Matrix4f inverse_bind = Eigen::Matrix4f::Identity();  // model space to bone space
};

/// How a bone moves over time, against its parent.
struct BoneTrack {
  enum class Of : std::uint8_t { position, rotation };
  enum class Between : std::uint8_t { step, linear, cubic };
  std::uint32_t bone = 0;
  Of of = Of::position;
  Between between = Between::linear;
  std::vector<double> times;  // s, rising
  /// x, y, z (m), or those and w, for each time; where it is cubic, between two tangents of as many
  /// numbers (per second).
  std::vector<float> values;

  std::size_t size() const { return of == Of::position ? 3 : 4; }  // numbers of a value
};

struct Animation {
  std::string name;
  std::vector<BoneTrack> tracks;
};

struct Model {
  std::string name;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Bone> bones;  // empty: not skinned
  std::vector<Animation> animations;
  std::vector<std::string> left_out;  // what of the file is not in it, for messages; a line each

  /// Index of a bone by name, or -1.
  int bone(std::string_view bone_name) const;
};

/// Makes all lengths of a model so many times as large.
void enlarge(Model& model, double scale);

/// Leaves out animations; adds to what is left out of `file`.
void leave_out_animations(Model& model, const std::string& file);

/// A model of something rigid: leaves out animations and bones, as it is at rest.
void make_rigid(Model& model, const std::string& file);

}  // namespace taut::scenes

namespace taut::scenes::model_limits {

// The limits of a model. A file beyond them is refused before it is parsed.

constexpr std::size_t bytes = 64u << 20;      // of a file, and of all buffers together
constexpr std::size_t files = 1024;           // that it names
constexpr std::size_t all_bytes = 2 * bytes;  // of the named files together
constexpr std::size_t meshes =
    4096;  // pieces of one material: glTF primitives, OBJ groups, instances
constexpr std::size_t nodes = 65536;
constexpr std::size_t depth = 128;  // of the tree of nodes
constexpr std::size_t bones = 256;
constexpr std::size_t vertices = 4u << 20;  // over all pieces, shared data counted for each
constexpr std::size_t indices = 24u << 20;
constexpr std::size_t keys = 16u << 20;  // numbers of all animations
// Of the process that reads a model. The largest allowed model takes about half of it.
constexpr std::size_t memory = 2048u << 20;
// Of the reply of that process: 8 million vertices with their indices, and the pictures.
constexpr std::size_t reply = 1024u << 20;
constexpr std::size_t pixels = 64u << 20;  // of all pictures

}  // namespace taut::scenes::model_limits
