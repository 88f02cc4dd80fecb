#include "scenes/model/import.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>

#include "scenes/files/regular_file.h"
#include "scenes/model/gltf.h"
#include "scenes/model/imported.h"
#include "scenes/model/obj.h"
#include "scenes/model/obj_files.h"

namespace taut::scenes {

Model import_model(const std::filesystem::path& file, const std::string& content) {
  std::string kind = file.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool gltf = kind == ".glb" || kind == ".gltf";
  if (!gltf && kind != ".obj")
    throw bad_asset(file, fmt::format("is a \"{}\" file, expected .glb, .gltf or .obj", kind));
  if (content.empty()) throw bad_asset(file, "empty file");

  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_ValidateDataStructure;
  const aiScene* scene = nullptr;
  if (gltf) {
    const std::string glb = checked_glb(file, content);
    scene = importer.ReadFileFromMemory(glb.data(), glb.size(), steps, "glb");
  } else {
    check_obj(file, content);
    steps |= aiProcess_JoinIdenticalVertices;  // so that faces without normals shade smoothly
    importer.SetIOHandler(new ObjFiles(file, content));  // which it deletes
    scene = importer.ReadFile(file.string(), steps);
  }
  if (!scene || !scene->mRootNode || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE))
    throw bad_asset(file, fmt::format("cannot be imported: {}", importer.GetErrorString()));
  return from_imported(file, *scene);
}

}  // namespace taut::scenes
