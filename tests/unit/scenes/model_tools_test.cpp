// Models as other programs write them: each is read, or what of it is not read is said.
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/files/error.h"
#include "scenes/model/load_model.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut::model_tools_test {
namespace {

using nlohmann::json;
using Floats3 = std::array<float, 3>;

class ModelTools : public testing::Test {
 protected:
  scenes::Model load(const std::string& name, const std::string& bytes) const {
    return scenes::load_model(folder_.write(name, bytes));
  }
  scenes::Model load(const Gltf& g) const { return load("a.glb", g.bytes()); }

  static json& primitive(Gltf& g) { return g.json["meshes"][0]["primitives"][0]; }
  static const scenes::Material& material(const scenes::Model& model) {
    return model.materials.at(model.meshes.at(0).material);
  }
  static void expect_left_out(const scenes::Model& model, const std::string& what) {
    const bool said = std::ranges::any_of(model.left_out, [&](const std::string& line) {
      return line.find("left out: " + what) != line.npos;
    });
    EXPECT_TRUE(said) << what << ", of " << model.left_out.size() << " lines";
  }

  Folder folder_;
};

void expect_near(const Floats3& found, const Floats3& expected, float tolerance = 1e-5f) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], tolerance) << i;
}

/// The skinned triangle in centimetres and lying on its back, below a node that makes metres of it
/// and has it stand: as programs write characters whose files had another unit and another axis up.
Gltf in_centimetres() {
  Gltf g = skinned();
  auto& attributes = g.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["POSITION"] = g.add<float>({0, 0, 0, 100, 0, 0, 0, 0, 100}, 5126, "VEC3", 3);
  g.json["skins"][0]["inverseBindMatrices"] =
      g.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -100, 1,
                    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -150, 1},
                   5126, "MAT4", 16);
  g.json["nodes"][1]["translation"] = {0, 0, 100};
  g.json["nodes"][2]["translation"] = {0, 0, 50};
  g.json["nodes"][3]["translation"] = {0, 0, 10};
  const double half = std::sqrt(0.5);
  g.json["nodes"].push_back({{"name", "Armature"},
                             {"scale", {0.01, 0.01, 0.01}},
                             {"rotation", {-half, 0, 0, half}},
                             {"children", {0, 1}}});
  g.json["scenes"] = {{{"nodes", {4}}}};
  return g;
}

TEST_F(ModelTools, CharactersInCentimetresBelowAScaledNode) {
  const scenes::Model model = load(in_centimetres());
  ASSERT_EQ(model.bones.size(), 4u);
  EXPECT_EQ(model.bones[0].name, "Armature");
  EXPECT_EQ(model.bones[1].name, "Root");
  Pose root = model.bones[0].rest, tip;
  root = {root.position + root.rotation * model.bones[1].rest.position,
          root.rotation * model.bones[1].rest.rotation};
  tip.position = root.position + root.rotation * model.bones[2].rest.position;
  EXPECT_LT((root.position - Vec3(0, 1, 0)).norm(), 1e-6);
  EXPECT_LT((tip.position - Vec3(0, 1.5, 0)).norm(), 1e-6);
  const std::vector<scenes::Vertex>& v = model.meshes.at(0).vertices;
  expect_near(v[1].position, {1, 0, 0});
  expect_near(v[2].position, {0, 1, 0});
  // The skin lies where the file has it: the rest pose moves nothing.
  Eigen::Matrix4f rest = Eigen::Matrix4f::Identity();
  rest.topLeftCorner<3, 3>() = root.rotation.toRotationMatrix().cast<float>();
  rest.topRightCorner<3, 1>() = root.position.cast<float>();
  EXPECT_LT((rest * model.bones[1].inverse_bind - Eigen::Matrix4f::Identity()).norm(), 1e-4f);
}

TEST_F(ModelTools, SkinsOfAllKinds) {
  Gltf bare = skinned();
  bare.json["skins"][0].erase("inverseBindMatrices");  // they are unit matrices then
  EXPECT_EQ(load(bare).bones.at(0).inverse_bind, Eigen::Matrix4f::Identity());

  Gltf eight = skinned();
  primitive(eight)["attributes"]["JOINTS_1"] = primitive(eight)["attributes"]["JOINTS_0"];
  primitive(eight)["attributes"]["WEIGHTS_1"] = primitive(eight)["attributes"]["WEIGHTS_0"];
  expect_left_out(load(eight), "all but four bones of each vertex (meshes[0])");

  Gltf loose = skinned();
  primitive(loose)["attributes"]["WEIGHTS_0"] =
      loose.add<float>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC4", 4);
  const scenes::Model follows = load(loose);
  expect_left_out(follows,
                  "weights of no bone (mesh \"Triangle\", 2 vertices: they follow \"Root\")");
  EXPECT_EQ(follows.meshes.at(0).vertices.at(2).weights, (std::array<float, 4>{1, 0, 0, 0}));

  Gltf twins = skinned();
  twins.json["nodes"][3]["name"] = "Root";  // an end that is named as another node
  EXPECT_EQ(load(twins).bones.at(2).name, "Root#3");
}

TEST_F(ModelTools, PositionsOfFewBits) {
  Gltf g = triangle();
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  auto& attributes = primitive(g)["attributes"];
  attributes["POSITION"] =
      g.add<std::int16_t>({0, 0, 0, 32767, 0, 0, 0, -32767, 0}, 5122, "VEC3", 3);
  g.json["accessors"].back()["normalized"] = true;
  const auto normal =
      g.add<std::int8_t>({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, 5120, "VEC3", 4);
  g.json["accessors"][normal]["count"] = 3;  // three bytes of four
  g.json["bufferViews"].back()["byteStride"] = 4;
  attributes["NORMAL"] = normal;
  const scenes::Model model = load(g);
  EXPECT_EQ(model.left_out.size(), 0u);
  expect_near(model.meshes.at(0).vertices[1].position, {12, 0, 0});
  expect_near(model.meshes.at(0).vertices[2].position, {10, -2, 0});
  expect_near(model.meshes.at(0).vertices[0].normal, {0, 0, 1});
}

TEST_F(ModelTools, NormalsOfZeroAreThoseOfTheFaces) {
  Gltf g = triangle();
  primitive(g)["attributes"]["NORMAL"] = g.add<float>({0, 0, 1, 0, 0, 0, 1, 0, 0}, 5126, "VEC3", 3);
  const scenes::Mesh mesh = load(g).meshes.at(0);
  expect_near(mesh.vertices[0].normal, {0, 0, 1});
  expect_near(mesh.vertices[1].normal, {0, 0, 1});
  expect_near(mesh.vertices[2].normal, {1, 0, 0});
}

TEST_F(ModelTools, StripsAndFans) {
  for (const int mode : {5, 6}) {
    Gltf g = triangle();
    primitive(g)["attributes"].erase("COLOR_0");
    primitive(g)["attributes"]["POSITION"] =
        g.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 5126, "VEC3", 3);
    primitive(g).erase("indices");
    primitive(g)["mode"] = mode;
    EXPECT_EQ(load(g).meshes.at(0).indices.size(), 6u) << mode;
  }
}

TEST_F(ModelTools, AFileWithoutAScene) {
  Gltf g = triangle();
  g.json.erase("scenes");
  EXPECT_EQ(load(g).meshes.size(), 1u);
}

/// A red PNG of one pixel.
constexpr const char* kRed =
    "data:image/png;base64,"
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC";

TEST_F(ModelTools, PlacesOnTexturesThatAreMoved) {
  Gltf g = triangle();
  primitive(g)["attributes"]["TEXCOORD_0"] = g.add<float>({0, 0, 1, 0, 0, 1}, 5126, "VEC2", 2);
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_texture_transform"};
  g.json["images"] = {{{"uri", kRed}}};
  g.json["textures"] = {{{"source", 0}}};
  g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0},
      {"extensions",
       {{"KHR_texture_transform",
         {{"offset", {0.25, 0.5}}, {"scale", {2, 3}}, {"rotation", M_PI / 2}}}}}};
  const scenes::Model model = load(g);
  EXPECT_EQ(model.left_out.size(), 0u);
  // Larger, then a quarter turn from right to up, which is towards smaller v, then moved.
  const std::array<float, 2> expected[] = {{0.25f, 0.5f}, {0.25f, -1.5f}, {3.25f, 0.5f}};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_NEAR(model.meshes.at(0).vertices[i].uv[k], expected[i][k], 1e-6f) << i << " " << k;
}

TEST_F(ModelTools, MaterialsOfTheOlderKind) {
  Gltf g = triangle();
  primitive(g)["attributes"]["TEXCOORD_0"] = g.add<float>({0, 0, 1, 0, 0, 1}, 5126, "VEC2", 2);
  g.json["images"] = {{{"uri", kRed}}};
  g.json["textures"] = {{{"source", 0}}};
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
  g.json["materials"] = {{{"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {0.5, 0.25, 1, 1}},
                              {"diffuseTexture", {{"index", 0}}},
                              {"glossinessFactor", 0.75},
                              {"specularGlossinessTexture", {{"index", 0}}}}}}}}};
  const scenes::Model model = load(g);
  expect_left_out(model, "specularGlossinessTexture (materials[0])");
  expect_near(material(model).base_color, {0.5f, 0.25f, 1});
  EXPECT_FLOAT_EQ(material(model).roughness, 0.25f);
  EXPECT_EQ(material(model).metallic, 0);
  EXPECT_EQ(material(model).texture, 0);
}

TEST_F(ModelTools, ExtensionsThatChangeLooksAreLeftOutAndOthersRefused) {
  Gltf g = triangle();
  g.json["extensionsUsed"] = g.json["extensionsRequired"] = {"KHR_materials_unlit"};
  expect_left_out(load(g), "the extension \"KHR_materials_unlit\"");
  g.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  try {
    load(g);
    ADD_FAILURE() << "accepted";
  } catch (const scenes::BadAsset& error) {
    EXPECT_NE(std::string(error.what()).find("\"KHR_draco_mesh_compression\""), std::string::npos);
  }
}

TEST_F(ModelTools, ObjFilesWithStatementsOfTheirOwn) {
  // As scanners, CAD programs and scripts write them.
  const scenes::Model model = load("a.obj",
                                   "\xef\xbb\xbf#cad\r\nunits mm\r\nv 0 0 0 1 0 0\r\n"
                                   "v 1 0 0 0 1 0\r\nv 0 1 0 0 0 1\r\nvn 0 0 0\r\n"
                                   "f 1//1 2//1\r\nf 1//1 2//1 3//1\r\nend_of_part\r\n");
  expect_left_out(model, "unknown (1 statement \"units\", first in line 2)");
  expect_left_out(model, "unknown (1 statement \"end_of_part\", first in line 9)");
  expect_left_out(model, "faces of fewer than three corners (1 statement \"f\", first in line 7)");
  const scenes::Mesh& mesh = model.meshes.at(0);
  EXPECT_EQ(mesh.indices.size(), 3u);
  expect_near(mesh.vertices[0].normal, {0, 0, 1});
  for (const scenes::Vertex& v : mesh.vertices) {
    const float sum = v.position[0] + v.position[1];
    expect_near(v.color, {1 - sum, v.position[0], v.position[1]});
  }
  folder_.write("a.mtl", "newmtl glass\nKd 0 0 1\nd 0.5\n");
  expect_left_out(load("b.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n"),
                  "d (a.mtl, 1 of them)");
}

}  // namespace
}  // namespace taut::model_tools_test
