// Models as they should be read: geometry, materials, skeletons.
#include "model_files.h"
#include "scenes/files/error.h"
#include "scenes/model/load_model.h"

namespace taut::model_load {
namespace {

using ModelLoad = ModelFiles;
using Array3 = std::array<float, 3>;

TEST_F(ModelLoad, NodesPlaceMeshesAndMaterialsKeepTheirFactors) {
  const scenes::Model model = scenes::load_model(write("t.glb", triangle().bytes()));
  ASSERT_EQ(model.meshes.size(), 1u);
  const scenes::Mesh& mesh = model.meshes[0];
  ASSERT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(mesh.vertices[1].position, (Array3{12, 0, 0}));
  EXPECT_EQ(mesh.vertices[1].normal, (Array3{0, 0, 1}));
  EXPECT_FLOAT_EQ(mesh.vertices[1].color[1], 0.2f);
  EXPECT_EQ(mesh.vertices[1].weights, (std::array<float, 4>{}));
  const scenes::Material& brass = model.materials[mesh.material];
  EXPECT_EQ(brass.name, "Brass");
  EXPECT_FLOAT_EQ(brass.base_color[1], 0.6f);
  EXPECT_FLOAT_EQ(brass.roughness, 0.25f);
  EXPECT_FLOAT_EQ(brass.metallic, 1);
  EXPECT_TRUE(model.bones.empty());
}

TEST_F(ModelLoad, AMirroredNodeKeepsFacesOutward) {
  Gltf g = triangle();
  g.json["nodes"][0]["scale"] = {-1, 1, 1};
  const scenes::Mesh mesh = scenes::load_model(write("t.glb", g.bytes())).meshes.at(0);
  const auto corner = [&](std::size_t i) { return mesh.vertices.at(mesh.indices.at(i)); };
  EXPECT_EQ(corner(0).position, (Array3{10, 0, 0}));
  EXPECT_EQ(corner(1).position, (Array3{10, 1, 0}));
  EXPECT_EQ(corner(2).position, (Array3{9, 0, 0}));
  EXPECT_EQ(corner(1).normal, (Array3{0, 0, 1}));
}

TEST_F(ModelLoad, SkeletonComesFromTheNodes) {
  const scenes::Model model = scenes::load_model(write("s.glb", skinned().bytes()));
  ASSERT_EQ(model.bones.size(), 3u);
  EXPECT_EQ(model.bones[0].name, "Root");
  EXPECT_EQ(model.bones[0].parent, -1);
  EXPECT_EQ(model.bone("Tip"), 1);
  EXPECT_EQ(model.bones[1].parent, 0);
  EXPECT_EQ(model.bone("End"), 2);
  EXPECT_EQ(model.bone("Nose"), -1);
  EXPECT_TRUE(model.bones[1].rest.position.isApprox(Vec3(0, 0.5, 0)));
  EXPECT_FLOAT_EQ(model.bones[1].inverse_bind(1, 3), -1.5f);
  EXPECT_FLOAT_EQ(model.bones[2].inverse_bind(1, 3), -1.6f);  // of its rest pose

  const auto& vertices = model.meshes.at(0).vertices;
  EXPECT_EQ(vertices[1].position, (Array3{1, 0, 0}));  // a skinned mesh ignores its node
  EXPECT_FLOAT_EQ(vertices[0].weights[0], 0.75f);
  EXPECT_EQ(vertices[0].bones[1], 1);
  EXPECT_FLOAT_EQ(vertices[1].weights[0], 1);  // 2 in the file
  EXPECT_EQ(vertices[1].bones[0], 1);
}

TEST_F(ModelLoad, AMeshUnderABoneMovesWithIt) {
  Gltf g = skinned();
  const auto position = g.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  g.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", position}}}}}}});
  g.json["nodes"].push_back({{"name", "Hat"}, {"mesh", 1}, {"translation", {0, 0.25, 0}}});
  g.json["nodes"][2]["children"].push_back(4);
  const scenes::Model model = scenes::load_model(write("s.glb", g.bytes()));
  ASSERT_EQ(model.meshes.size(), 2u);
  const scenes::Vertex& corner = model.meshes[1].vertices[1];
  EXPECT_EQ(corner.position, (Array3{1, 1.75, 0}));
  EXPECT_EQ(corner.bones[0], model.bone("Tip"));
  EXPECT_EQ(corner.weights, (std::array<float, 4>{1, 0, 0, 0}));
}

TEST_F(ModelLoad, GltfReadsItsBufferFromAFileOrFromText) {
  Gltf g = triangle();
  write("data.bin", g.binary);
  g.json["buffers"][0]["uri"] = "data.bin";
  EXPECT_EQ(scenes::load_model(write("t.gltf", g.json.dump())).meshes.at(0).vertices.size(), 3u);
  // "AAAA" is three bytes of zero.
  std::string zeros((g.binary.size() + 2) / 3 * 4, 'A');
  g.json["buffers"][0]["uri"] = "data:application/octet-stream;base64," + zeros;
  EXPECT_EQ(scenes::load_model(write("t.gltf", g.json.dump())).meshes.at(0).vertices[1].position,
            (Array3{10, 0, 0}));
}

TEST_F(ModelLoad, ObjFacesWithoutNormalsAreSmooth) {
  const scenes::Model model =
      scenes::load_model(write("roof.obj",
                               "o roof\nv -1 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 2\nv 0 1 2\n"
                               "v 1 0 2\nf 1 4 5 2\nf -5 -2 -1 -4\n"));
  ASSERT_EQ(model.meshes.size(), 1u);
  EXPECT_EQ(model.meshes[0].vertices.size(), 6u);
  EXPECT_EQ(model.meshes[0].indices.size(), 12u);
  for (const scenes::Vertex& v : model.meshes[0].vertices) {
    if (v.position[1] == 1) {  // on the ridge, straight up
      EXPECT_NEAR(v.normal[1], 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace taut::model_load
