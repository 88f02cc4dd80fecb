// The reader of a model: its checked file goes through the importer (assimp), whose structures
// become a Model.
#include "scenes/model/import.h"

#include <assimp/GltfMaterial.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/files/error.h"
#include "scenes/files/files.h"
#include "scenes/model/formats.h"
#include "scenes/model/model.h"
#include "sim/motion/printable.h"

struct aiScene;

namespace taut::scenes {
namespace {

// The files that an OBJ model is read from.

/// Gives the importer a checked model and its materials, and no other file.
class ObjFiles : public Assimp::IOSystem {
 public:
  static constexpr const char* kModel = "model.obj";

  explicit ObjFiles(const CheckedObj& model);

  bool Exists(const char* name) const override { return bytes_of(name) != nullptr; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string* bytes_of(const char* name) const;

  std::string text_;
  const std::string& materials_;
};

constexpr const char* kMaterials = "model.mtl";

/// Bytes as the importer reads a file.
class Bytes : public Assimp::IOStream {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET   ? 0
                             : origin == aiOrigin_CUR ? at_
                                                      : bytes_.size();
    if (offset > bytes_.size() - from) return aiReturn_FAILURE;
    at_ = from + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

ObjFiles::ObjFiles(const CheckedObj& model)
    : text_(fmt::format("mtllib {}\n{}", kMaterials, model.text)), materials_(model.materials) {}

const std::string* ObjFiles::bytes_of(const char* name) const {
  const std::filesystem::path file = std::filesystem::path(name).filename();
  return file == kModel ? &text_ : file == kMaterials ? &materials_ : nullptr;
}

Assimp::IOStream* ObjFiles::Open(const char* name, const char*) {
  const std::string* bytes = bytes_of(name);
  return bytes ? new Bytes(*bytes) : nullptr;
}

// From the importer's structures to a Model.

using Mat4 = Eigen::Matrix4d;

constexpr std::size_t vertex_limit = 2 * model_limits::vertices;  // after instancing

Mat4 matrix(const aiMatrix4x4& m) {
  return Eigen::Map<const Eigen::Matrix<ai_real, 4, 4, Eigen::RowMajor>>(&m.a1).cast<double>();
}

std::string text(const aiString& s) {
  return std::string(s.C_Str(), s.length);
}

std::array<float, 3> array3(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Vec3 vec3(const aiVector3D& v) {
  return {v.x, v.y, v.z};
}

/// Sums of the faces' normals weighted by their angle at each vertex, for meshes that bring none:
/// the way in which polygons are cut into triangles does not show.
std::vector<Vec3> smooth_normals(const aiMesh& mesh) {
  std::vector<Vec3> sums(mesh.mNumVertices, Vec3::Zero());
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    if (mesh.mFaces[f].mNumIndices != 3) continue;
    const unsigned* corner = mesh.mFaces[f].mIndices;
    for (unsigned k = 0; k < 3; ++k) {
      const Vec3 at = vec3(mesh.mVertices[corner[k]]);
      const Vec3 next = vec3(mesh.mVertices[corner[(k + 1) % 3]]) - at;
      const Vec3 last = vec3(mesh.mVertices[corner[(k + 2) % 3]]) - at;
      const Vec3 area = next.cross(last);
      sums[corner[k]] += std::atan2(area.norm(), next.dot(last)) * area.normalized();
    }
  }
  return sums;
}

/// Gives each triangle vertices of its own, with the normal of its face.
void make_flat(Mesh& mesh) {
  std::vector<Vertex> vertices;
  vertices.reserve(mesh.indices.size());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return mesh.vertices[mesh.indices[i + k]]; };
    const auto at = [&](std::size_t k) {
      return Eigen::Vector3f(corner(k).position.data()).cast<double>().eval();
    };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0));
    const Vec3 normal = area.isZero(0) ? Vec3(0, 1, 0) : area.stableNormalized();
    for (std::size_t k = 0; k < 3; ++k) {
      vertices.push_back(corner(k));
      vertices.back().normal = array3(normal);
    }
  }
  mesh.vertices = std::move(vertices);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    mesh.indices[i] = static_cast<std::uint32_t>(i);
  }
}

class Import {
 public:
  Import(const std::filesystem::path& file, const aiScene& scene, bool flat,
         const Textures& textures, NodeAnimations animations)
      : file_(file),
        scene_(scene),
        flat_(flat),
        textures_(textures),
        animations_(std::move(animations)) {}

  Model run() {
    model_.name = file_.stem().string();
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) add_material(*scene_.mMaterials[i]);
    find_bones();
    add_node(*scene_.mRootNode, Mat4::Identity(), -1);
    set_inverse_binds();
    take_animations();
    for (const Instance& instance : instances_) add_mesh(instance);
    if (model_.meshes.empty()) fail("has no triangles");
    return std::move(model_);
  }

 private:
  /// A mesh as a node places it.
  struct Instance {
    const aiMesh* mesh;
    Mat4 world;
    int bone;  // the nearest one above the node, or -1
  };

  /// What the rest pose makes of the points of a skinned mesh, if it is the same for all bones.
  struct Rest {
    Mat4 move = Mat4::Identity();
    bool same = true, identity = true;
  };

  [[noreturn]] void fail(const std::string& cause) const { throw bad_asset(file_, cause); }

  void add_material(const aiMaterial& in) {
    Material out;
    out.name = text(in.GetName());
    const std::size_t index = model_.materials.size();
    const auto named = textures_.of_name.find(out.name);
    if (named != textures_.of_name.end()) out.texture = named->second;
    if (index < textures_.of_material.size()) out.texture = textures_.of_material[index];
    aiColor4D color;
    if (in.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS ||
        in.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS)
      out.base_color = {color.r, color.g, color.b};
    in.Get(AI_MATKEY_ROUGHNESS_FACTOR, out.roughness);
    in.Get(AI_MATKEY_METALLIC_FACTOR, out.metallic);
    const auto in_range = [](float x, float most) { return x >= 0 && x <= most; };
    for (const float channel : out.base_color)
      if (!in_range(channel, 1e3f)) fail(fmt::format("material \"{}\": bad colour", out.name));
    if (!in_range(out.roughness, 1) || !in_range(out.metallic, 1))
      fail(fmt::format("material \"{}\": roughness and metallic must be 0 to 1", out.name));
    model_.materials.push_back(out);
  }

  /// The skeleton: nodes that skins name, all above them but a root that does nothing, and all
  /// below them that carry no mesh.
  void find_bones() {
    std::set<std::string> joints;
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i)
      for (unsigned b = 0; b < scene_.mMeshes[i]->mNumBones; ++b)
        joints.insert(text(scene_.mMeshes[i]->mBones[b]->mName));
    for (const Animation& animation : animations_.all)
      for (const BoneTrack& track : animation.tracks) joints.insert(animations_.nodes[track.bone]);
    if (!joints.empty()) mark(*scene_.mRootNode, joints, false);
    const aiNode* root = scene_.mRootNode;
    if (!joints.contains(text(root->mName)) && root->mTransformation.IsIdentity())
      bone_nodes_.erase(root);
  }

  bool mark(const aiNode& node, const std::set<std::string>& joints, bool below) {
    const bool joint = joints.contains(text(node.mName));
    bool above = joint;
    for (unsigned i = 0; i < node.mNumChildren; ++i)
      above |= mark(*node.mChildren[i], joints, below || joint);
    if (above || (below && node.mNumMeshes == 0)) bone_nodes_.insert(&node);
    return above;
  }

  void add_node(const aiNode& node, const Mat4& parent_world, int parent) {
    const Mat4 local = matrix(node.mTransformation);
    const Mat4 world = parent_world * local;
    if (!world.allFinite()) fail(fmt::format("node \"{}\" is not finite", text(node.mName)));
    int bone = parent;
    if (bone_nodes_.contains(&node)) {
      Bone out;
      out.name = text(node.mName);
      out.parent = parent;
      const Mat3 rotation = local.topLeftCorner<3, 3>();
      const bool rigid = (rotation.transpose() * rotation - Mat3::Identity()).norm() <= 1e-3 &&
                         rotation.determinant() > 0;
      Mat4 rest = world;
      if (rigid && (parent < 0 || node_world_[index(parent)] == rest_world_[index(parent)])) {
        out.rest = {local.topRightCorner<3, 1>(), Quat(rotation).normalized()};
      } else {
        rest = without_scale(world, out.name);
        const Mat4 own = parent < 0 ? rest : (rest_world_[index(parent)].inverse() * rest).eval();
        out.rest = {own.topRightCorner<3, 1>(), Quat(Mat3(own.topLeftCorner<3, 3>())).normalized()};
      }
      bone = static_cast<int>(model_.bones.size());
      model_.bones.push_back(out);
      node_world_.push_back(world);
      rest_world_.push_back(rest);
      if (model_.bones.size() > model_limits::bones)
        fail(fmt::format("more than {} bones", model_limits::bones));
    }
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      instances_.push_back({scene_.mMeshes[node.mMeshes[i]], world, bone});
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_node(*node.mChildren[i], world, bone);
  }

  static std::size_t index(int bone) { return static_cast<std::size_t>(bone); }

  /// A bone's place without the scales of the nodes above it.
  Mat4 without_scale(const Mat4& world, const std::string& name) const {
    const Mat3 linear = world.topLeftCorner<3, 3>();
    if (!(linear.determinant() > 1e-18)) fail(fmt::format("bone \"{}\" is scaled", name));
    const Eigen::JacobiSVD<Mat3> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat4 rest = world;
    rest.topLeftCorner<3, 3>() = svd.matrixU() * svd.matrixV().transpose();
    return rest;
  }

  std::size_t bone_of(const aiBone& bone) const {
    const int found = model_.bone(text(bone.mName));
    if (found < 0) fail(fmt::format("bone \"{}\" is no node", text(bone.mName)));
    if (!matrix(bone.mOffsetMatrix).allFinite())
      fail(fmt::format("bone \"{}\" is not finite", text(bone.mName)));
    return index(found);
  }

  /// How a skinned mesh lies in the rest pose.
  Rest rest_of(const aiMesh& mesh) const {
    constexpr double kAlike = 1e-3;  // of matrices, against their size
    Rest rest;
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const aiBone& bone = *mesh.mBones[b];
      const Mat4 move = node_world_[bone_of(bone)] * matrix(bone.mOffsetMatrix);
      if (b == 0) rest.move = move;
      rest.identity &= (move - Mat4::Identity()).norm() < kAlike;
      rest.same &= (move - rest.move).norm() < kAlike * rest.move.norm();
    }
    rest.same &= std::abs(rest.move.topLeftCorner<3, 3>().determinant()) > 1e-12;
    return rest;
  }

  /// From the skins; a bone that moves no vertex gets the inverse of its rest pose, and so do those
  /// of skins that the rest pose moves as a whole, as a skeleton in centimetres: there the vertices
  /// are moved instead.
  void set_inverse_binds() {
    std::vector<std::optional<Mat4>> given(model_.bones.size());
    std::vector<Rest> rests(scene_.mNumMeshes);
    bool moved = true;
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) {
      rests[i] = rest_of(*scene_.mMeshes[i]);
      moved &= rests[i].same || rests[i].identity;
    }
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) {
      const aiMesh& mesh = *scene_.mMeshes[i];
      if (moved && !rests[i].identity) {
        moved_[&mesh] = rests[i].move;
        continue;
      }
      for (unsigned b = 0; b < mesh.mNumBones; ++b) {
        const aiBone& bone = *mesh.mBones[b];
        const std::size_t k = bone_of(bone);
        Mat4 offset = matrix(bone.mOffsetMatrix);
        if (node_world_[k] != rest_world_[k])
          offset = rest_world_[k].inverse() * node_world_[k] * offset;
        if (given[k] && !given[k]->isApprox(offset, 1e-4))
          fail(fmt::format("bone \"{}\" has two inverse bind matrices", text(bone.mName)));
        given[k] = offset;
      }
    }
    inverse_bind_.resize(given.size());
    for (std::size_t i = 0; i < given.size(); ++i) {
      inverse_bind_[i] = given[i].value_or(rest_world_[i].inverse());
      model_.bones[i].inverse_bind = inverse_bind_[i].cast<float>();
    }
  }

  /// Positions are lengths in the frame of the parent, which is without its scale here.
  void take_animations() {
    for (Animation& animation : animations_.all) {
      std::erase_if(animation.tracks, [&](BoneTrack& track) {
        const int bone = model_.bone(animations_.nodes[track.bone]);
        if (bone < 0) return true;
        track.bone = static_cast<std::uint32_t>(bone);
        const int parent = model_.bones[track.bone].parent;
        if (track.of == BoneTrack::Of::rotation || parent < 0) return false;
        const auto scale = static_cast<float>(
            std::cbrt(node_world_[index(parent)].topLeftCorner<3, 3>().determinant()));
        if (std::abs(scale - 1) > 1e-6f)
          for (float& x : track.values) x *= scale;
        return false;
      });
    }
    model_.animations = std::move(animations_.all);
  }

  void add_mesh(const Instance& instance) {
    const aiMesh& in = *instance.mesh;
    const bool skinned = in.mNumBones > 0;
    // A skinned mesh ignores its node; one that merely hangs on a bone moves with it rigidly; any
    // other is placed by its node.
    const auto moved = moved_.find(&in);
    Mat4 place = !skinned                ? instance.world
                 : moved != moved_.end() ? moved->second
                                         : Mat4::Identity();
    if (!skinned && instance.bone >= 0) {
      const auto bone = static_cast<std::size_t>(instance.bone);
      place = (rest_world_[bone] * inverse_bind_[bone]).inverse() * instance.world;
    }
    const Mat3 linear = place.topLeftCorner<3, 3>();
    const double scale = linear.determinant();
    if (!(std::abs(scale) > 1e-12))
      fail(fmt::format("mesh \"{}\" is scaled to nothing", text(in.mName)));
    const Mat3 for_normals = linear.inverse().transpose();

    Mesh out;
    out.name = text(in.mName);
    out.material = in.mMaterialIndex;
    if (out.material >= model_.materials.size())
      fail(fmt::format("mesh \"{}\" has material {}", out.name, out.material));
    if (!in.HasTextureCoords(0)) out.material = without_texture(out.material);
    vertices_ += in.mNumVertices;
    if (vertices_ > vertex_limit) fail(fmt::format("more than {} vertices", vertex_limit));
    out.indices = triangles(in, scale < 0);
    out.vertices.resize(in.mNumVertices);
    std::vector<Vec3> own;
    const auto is_zero = [](const aiVector3D& n) { return n.x == 0 && n.y == 0 && n.z == 0; };
    if (!in.HasNormals() || std::any_of(in.mNormals, in.mNormals + in.mNumVertices, is_zero))
      own = smooth_normals(in);
    for (std::size_t i = 0; i < out.vertices.size(); ++i) {
      const Vec3 position =
          place.topLeftCorner<3, 3>() * vec3(in.mVertices[i]) + place.topRightCorner<3, 1>();
      const bool given = in.HasNormals() && !is_zero(in.mNormals[i]);
      const Vec3 normal = for_normals * (given ? vec3(in.mNormals[i]) : own[i]);
      if (!position.allFinite() || position.norm() > 1e6 || !normal.allFinite())
        fail(fmt::format("mesh \"{}\": vertex {} is not finite", out.name, i));
      Vertex& v = out.vertices[i];
      v.position = array3(position);
      v.normal = array3(normal.norm() > 1e-12 ? normal.normalized() : Vec3(0, 1, 0));
      if (in.HasVertexColors(0)) {
        const aiColor4D& c = in.mColors[0][i];
        if (!(c.r >= 0 && c.g >= 0 && c.b >= 0 && c.r + c.g + c.b < 1e3f))
          fail(fmt::format("mesh \"{}\": the colour of vertex {} is wrong", out.name, i));
        v.color = {c.r, c.g, c.b};
      }
      if (in.HasTextureCoords(0)) {
        const aiVector3D& at = in.mTextureCoords[0][i];  // the importer counts v from below
        v.uv = {static_cast<float>(at.x), 1 - static_cast<float>(at.y)};
        if (!(std::abs(v.uv[0]) < 1e6f && std::abs(v.uv[1]) < 1e6f))
          fail(fmt::format("mesh \"{}\": vertex {} is nowhere on its texture", out.name, i));
      }
    }
    if (skinned) {
      add_weights(in, out);
    } else if (instance.bone >= 0) {
      for (Vertex& v : out.vertices) {
        v.bones[0] = static_cast<std::uint16_t>(instance.bone);
        v.weights[0] = 1;
      }
    }
    if (!in.HasNormals() && flat_) {
      vertices_ += out.indices.size();
      if (vertices_ > vertex_limit) fail(fmt::format("more than {} vertices", vertex_limit));
      make_flat(out);
    }
    if (!out.indices.empty()) model_.meshes.push_back(std::move(out));
  }

  /// The same material for a mesh that has no place on its texture.
  std::size_t without_texture(std::size_t material) {
    if (model_.materials[material].texture < 0) return material;
    const auto known = untextured_.find(material);
    if (known != untextured_.end()) return known->second;
    Material copy = model_.materials[material];
    copy.texture = -1;
    model_.materials.push_back(std::move(copy));
    return untextured_[material] = model_.materials.size() - 1;
  }

  std::vector<std::uint32_t> triangles(const aiMesh& in, bool mirrored) const {
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * std::size_t{in.mNumFaces});
    for (unsigned f = 0; f < in.mNumFaces; ++f) {
      const aiFace& face = in.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      for (const unsigned k : {0u, mirrored ? 2u : 1u, mirrored ? 1u : 2u}) {
        if (face.mIndices[k] >= in.mNumVertices)
          fail(fmt::format("mesh \"{}\": index {} is out of range", text(in.mName),
                           face.mIndices[k]));
        indices.push_back(face.mIndices[k]);
      }
    }
    return indices;
  }

  void add_weights(const aiMesh& in, Mesh& out) {
    std::vector<int> used(out.vertices.size(), 0);
    const auto first = static_cast<std::uint16_t>(bone_of(*in.mBones[0]));
    std::size_t loose = 0;  // vertices without weights
    for (unsigned b = 0; b < in.mNumBones; ++b) {
      const aiBone& bone = *in.mBones[b];
      const auto index = static_cast<std::uint16_t>(model_.bone(text(bone.mName)));
      for (unsigned k = 0; k < bone.mNumWeights; ++k) {
        const auto [vertex, weight] = bone.mWeights[k];
        if (vertex >= out.vertices.size() || !(weight >= 0 && weight <= 1e3f))
          fail(fmt::format("bone \"{}\" has a broken weight", text(bone.mName)));
        if (weight == 0) continue;
        if (used[vertex] == 4) fail(fmt::format("mesh \"{}\": more than 4 weights", out.name));
        const auto slot = static_cast<std::size_t>(used[vertex]++);
        out.vertices[vertex].bones[slot] = index;
        out.vertices[vertex].weights[slot] = weight;
      }
    }
    for (std::size_t i = 0; i < out.vertices.size(); ++i) {
      auto& w = out.vertices[i].weights;
      const float sum = w[0] + w[1] + w[2] + w[3];
      if (!(sum > 1e-6f)) {
        out.vertices[i].bones = {first, 0, 0, 0};
        w = {1, 0, 0, 0};
        ++loose;
        continue;
      }
      for (float& weight : w) weight /= sum;
    }
    if (loose > 0)
      model_.left_out.push_back(
          fmt::format("weights of no bone (mesh \"{}\", {} vertices: they follow \"{}\")", out.name,
                      loose, model_.bones[first].name));
  }

  const std::filesystem::path& file_;
  const aiScene& scene_;
  bool flat_;
  const Textures& textures_;
  NodeAnimations animations_;
  Model model_;
  std::set<const aiNode*> bone_nodes_;
  std::vector<Mat4> node_world_;                 // of each bone, as the file has it
  std::vector<Mat4> rest_world_, inverse_bind_;  // of each bone, without its scale
  std::map<const aiMesh*, Mat4> moved_;          // skinned ones, by their rest pose
  std::vector<Instance> instances_;
  std::map<std::size_t, std::size_t> untextured_;
  std::size_t vertices_ = 0;
};

/// Every mesh of the scene in model space, its materials, and the nodes of its skeleton, which are
/// those that skins name or animations move. Throws BadAsset for values that no model may hold.
/// Meshes without normals get those of their faces where `flat`, else means of these at each
/// vertex.
Model from_imported(const std::filesystem::path& file, const aiScene& scene, bool flat,
                    Textures textures, NodeAnimations animations) {
  const auto made = [&](NodeAnimations of) {
    return Import(file, scene, flat, textures, std::move(of)).run();
  };
  Model model;
  std::string cause;  // why it has no animations
  if (!animations.all.empty()) {
    try {
      model = made(std::move(animations));
    } catch (const BadAsset& error) {
      cause = error.what();
    }
  }
  if (model.meshes.empty()) model = made({});
  if (!cause.empty()) model.left_out.push_back(fmt::format("animations ({})", cause));
  model.textures = std::move(textures.all);
  return model;
}

}  // namespace

std::optional<Model> import_model(const std::filesystem::path& file, const std::string& content,
                                  NamedFiles& files) {
  std::string kind = file.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool gltf = kind == ".glb" || kind == ".gltf";
  if (!gltf && kind != ".obj" && kind != ".bvh")
    throw bad_asset(file,
                    fmt::format("is a \"{}\" file, expected .glb, .gltf, .obj or .bvh", kind));
  if (content.empty()) throw bad_asset(file, "empty file");
  if (kind == ".bvh") return read_bvh(file, content);

  std::optional<CheckedObj> obj;
  std::vector<std::string> left_out;
  Textures textures;
  NodeAnimations animations;
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure;
  const aiScene* scene = nullptr;
  if (gltf) {
    std::optional<CheckedGltf> checked = checked_gltf(file, content, files);
    if (!checked) return {};
    left_out = std::move(checked->left_out);
    textures.all = std::move(checked->textures);
    textures.of_material = std::move(checked->texture_of);
    animations = {std::move(checked->animations), std::move(checked->nodes)};
    scene = importer.ReadFileFromMemory(checked->glb.data(), checked->glb.size(), steps, "glb");
  } else {
    obj = checked_obj(file, content, files);
    if (!obj) return {};
    left_out = std::move(obj->left_out);
    textures = std::move(obj->textures);
    steps |= aiProcess_JoinIdenticalVertices;   // so that faces without normals shade smoothly
    importer.SetIOHandler(new ObjFiles(*obj));  // which it deletes
    scene = importer.ReadFile(ObjFiles::kModel, steps);
  }
  if (!scene || !scene->mRootNode || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE))
    throw bad_asset(file, fmt::format("cannot be imported: {}", importer.GetErrorString()));
  // What brings no normals is flat by glTF's rule; faces of an OBJ are smooth.
  Model model = from_imported(file, *scene, gltf, std::move(textures), std::move(animations));
  std::ranges::copy(model.left_out, std::back_inserter(left_out));
  model.left_out.clear();
  for (const std::string& what : left_out) {
    model.left_out.push_back(printable(fmt::format("{}: left out: {}", file.string(), what)));
  }
  return model;
}

}  // namespace taut::scenes
