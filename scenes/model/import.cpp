#include "scenes/model/import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>

#include "scenes/files/regular_file.h"
#include "scenes/model/bvh.h"
#include "scenes/model/gltf.h"
#include "scenes/model/imported.h"
#include "scenes/model/obj.h"
#include "scenes/model/obj_files.h"
#include "sim/motion/printable.h"

namespace taut::scenes {

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
