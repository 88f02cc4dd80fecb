// What of a model's file is read, and what is said of the rest.
#include <gtest/gtest.h>

#include "scenes/files/error.h"
#include "scenes/model/load_model.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut::model_parts_test {
namespace {

using nlohmann::json;
using Lines = std::vector<std::string>;

/// Of 2x2 pixels: red, green; blue, white.
const std::string kPng(
    "\211PNG\015\012\032\012\000\000\000\015IHDR\000\000\000\002\000\000\000\002\010\002\000"
    "\000\000\375\324\232s\000\000\000\022IDATx\332c\370\317\300\300\000\302\014\377\201\000"
    "\000\037\356\005\373\361\253\272w\000\000\000\000IEND\256B`\202",
    75);

class ModelParts : public testing::Test {
 protected:
  scenes::Model load(const std::string& name, const std::string& bytes) const {
    return scenes::load_model(folder_.write(name, bytes));
  }
  /// What is left out, without the file's name.
  Lines left_out(const scenes::Model& model, const std::string& name) const {
    const std::string start = (folder_.path() / name).string() + ": left out: ";
    Lines lines;
    for (const std::string& line : model.left_out) {
      EXPECT_EQ(line.substr(0, start.size()), start);
      lines.push_back(line.substr(start.size()));
    }
    return lines;
  }
  std::string complaint(const std::string& name, const std::string& bytes) const {
    try {
      load(name, bytes);
    } catch (const scenes::BadAsset& error) {
      return error.what();
    }
    return "accepted";
  }

  Folder folder_;
};

/// The triangle with a picture on it.
Gltf textured() {
  Gltf g = triangle();
  auto& primitive = g.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] = g.add<float>({0, 0, 1, 0, 0.25f, 0.75f}, 5126, "VEC2", 2);
  g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  g.json["textures"] = {{{"source", 0}}};
  g.json["images"] = {{{"uri", "a%20picture.png"}}};
  return g;
}

TEST_F(ModelParts, PicturesOfColours) {
  folder_.write("a picture.png", kPng);
  Gltf g = textured();
  const scenes::Model model = load("a.glb", g.bytes());
  EXPECT_EQ(model.left_out, Lines());
  ASSERT_EQ(model.textures.size(), 1u);
  const scenes::Texture& texture = model.textures[0];
  EXPECT_EQ(texture.width, 2u);
  EXPECT_EQ(texture.height, 2u);
  EXPECT_EQ(texture.pixels, (std::vector<std::uint8_t>{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255,
                                                       255, 255, 255, 255, 255}));
  EXPECT_EQ(texture.wrap_u, 10497u);
  EXPECT_EQ(texture.minify, 9987u);
  EXPECT_EQ(model.materials[model.meshes[0].material].texture, 0);
  EXPECT_EQ(model.meshes[0].vertices[2].uv, (std::array<float, 2>{0.25f, 0.75f}));

  // In a view of the buffer, with a sampler, by another set of places.
  g.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  g.json["textures"][0]["sampler"] = 0;
  std::vector<std::uint8_t> bytes(kPng.begin(), kPng.end());
  bytes.resize((bytes.size() + 3) / 4 * 4);
  g.add<std::uint8_t>(bytes, 5121, "SCALAR", 1);
  g.json["images"][0] = {{"bufferView", g.json["bufferViews"].size() - 1},
                         {"mimeType", "image/png"}};
  auto& attributes = g.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_1"] = g.add<std::uint16_t>({0, 0, 65535, 0, 0, 65535}, 5123, "VEC2", 2);
  g.json["accessors"].back()["normalized"] = true;
  g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  const scenes::Model other = load("b.glb", g.bytes());
  ASSERT_EQ(other.textures.size(), 1u);
  EXPECT_EQ(other.textures[0].pixels, texture.pixels);
  EXPECT_EQ(other.textures[0].wrap_u, 33071u);
  EXPECT_EQ(other.textures[0].wrap_v, 33648u);
  EXPECT_EQ(other.textures[0].magnify, 9728u);
  EXPECT_EQ(other.meshes[0].vertices[2].uv, (std::array<float, 2>{0, 1}));

  folder_.write("a.mtl", "newmtl red paint\nKd 1 1 1\nmap_Kd a picture.png\n");
  const scenes::Model obj = load("a.obj",
                                 "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvt 1 1\n"
                                 "vt 0 0\nusemtl red paint\nf 1/1 2/2 3/3\n");
  ASSERT_EQ(obj.textures.size(), 1u);
  EXPECT_EQ(obj.materials[obj.meshes[0].material].texture, 0);
  for (const scenes::Vertex& v : obj.meshes[0].vertices) {
    EXPECT_EQ(v.uv, (std::array<float, 2>{v.position[0], v.position[1]}));
  }
}

TEST_F(ModelParts, PicturesThatAreNone) {
  const std::string name = "images[0] \"a%20picture.png\"";
  folder_.write("a picture.png", kPng.substr(0, 60));
  const std::string said = complaint("a.glb", textured().bytes());
  EXPECT_NE(said.find("a.glb: " + name + ": "), said.npos) << said;
  folder_.write("a picture.png", "\xff\xd8\xff is no JPEG");
  const std::string jpeg = complaint("a.glb", textured().bytes());
  EXPECT_NE(jpeg.find("a.glb: " + name + ": "), jpeg.npos) << jpeg;
  folder_.write("a picture.png", "RIFF....WEBP");
  const scenes::Model webp = load("a.glb", textured().bytes());
  EXPECT_EQ(left_out(webp, "a.glb"), Lines{"textures other than PNG and JPEG (" + name + ")"});
  EXPECT_EQ(webp.materials[webp.meshes[0].material].texture, -1);
  std::string large = kPng;
  large[18] = 1, large[22] = 1;  // 65538 x 65538 pixels
  folder_.write("a picture.png", large);
  EXPECT_NE(complaint("a.glb", textured().bytes()), "accepted");

  folder_.write("a picture.png", kPng);
  Gltf g = textured();
  g.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  const scenes::Model nowhere = load("a.glb", g.bytes());
  EXPECT_EQ(left_out(nowhere, "a.glb"), Lines{"a texture without TEXCOORD_0 (meshes[0])"});
  EXPECT_EQ(nowhere.materials[nowhere.meshes[0].material].texture, -1);
}

TEST_F(ModelParts, WhatIsLeftOutOfAGltfIsSaid) {
  Gltf g = triangle();
  auto& primitives = g.json["meshes"][0]["primitives"];
  json line = primitives[0];
  line["mode"] = 1;
  primitives.push_back(line);
  line["mode"] = 0;
  primitives.push_back(line);
  primitives[0]["targets"] = {{{"POSITION", 0}}};
  g.json["meshes"].push_back({{"primitives", {line}}});
  g.json["nodes"].push_back({{"mesh", 1}});
  g.json["scenes"][0]["nodes"].push_back(1);
  g.json["animations"] = {json::object()};  // moves nothing
  g.json["extensionsUsed"] = {"KHR_lights_punctual"};
  g.json["materials"][0]["normalTexture"] = {{"index", 0}};
  g.json["materials"][0]["alphaMode"] = "BLEND";
  const scenes::Model model = load("a.glb", g.bytes());
  EXPECT_EQ(model.meshes.size(), 1u);
  EXPECT_EQ(left_out(model, "a.glb"),
            (Lines{"morph targets (meshes[0])", "normalTexture (materials[0])",
                   "points and lines (meshes[0], 3 in all)",
                   "the extension \"KHR_lights_punctual\" (extensionsUsed)",
                   "transparency (materials[0])"}));
}

TEST_F(ModelParts, AGltfWithoutNormalsIsFlat) {
  Gltf g = triangle();
  auto& primitive = g.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] =
      g.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 5126, "VEC3", 3);
  primitive["attributes"].erase("COLOR_0");
  primitive["indices"] = g.add<std::uint16_t>({0, 1, 2, 0, 3, 1}, 5123, "SCALAR", 1);
  const scenes::Mesh mesh = load("a.glb", g.bytes()).meshes.at(0);
  ASSERT_EQ(mesh.vertices.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::array<float, 3> normal =
        i < 3 ? std::array<float, 3>{0, 0, 1} : std::array<float, 3>{0, 1, 0};
    EXPECT_EQ(mesh.vertices[mesh.indices[i]].normal, normal) << i;
  }
}

TEST_F(ModelParts, ObjFilesOfManyPrograms) {
  folder_.write("my colours.mtl", "\xef\xbb\xbfnewmtl red paint\nKd 0.8 0.1 0.1\n");
  folder_.write("b.mtl", "newmtl blue\nKd 0 0 1\nmap_Bump bump.png\n");
  const scenes::Model model = load("a.obj",
                                   "\xef\xbb\xbf# made \\\r\nmtllib my colours.mtl\r\n"
                                   "mtllib b.mtl none.mtl\r\nusemtl red paint\r\nv 0 0 0\r\n"
                                   "v 1 0 \\\r\n 0\r\nv 0 1 0\r\nf 1 \\\r\n2 3\r\n"
                                   "usemap none\r\nl 1 2\r\np 1\r\nl 2 3\r\n");
  ASSERT_EQ(model.meshes.size(), 1u);
  EXPECT_EQ(model.meshes[0].indices.size(), 3u);
  const scenes::Material& red = model.materials[model.meshes[0].material];
  EXPECT_EQ(red.name, "red paint");
  EXPECT_EQ(red.base_color, (std::array<float, 3>{0.8f, 0.1f, 0.1f}));
  EXPECT_EQ(left_out(model, "a.obj"),
            (Lines{"materials (line 3: mtllib \"none.mtl\": there is no such file)",
                   "lines (2 statements \"l\", first in line 12)",
                   "points (1 statement \"p\", first in line 13)",
                   "textures (1 statement \"usemap\", first in line 11)",
                   "map_Bump (b.mtl, 1 of them)"}));
}

TEST_F(ModelParts, LibrariesOfMaterialsAreCheckedBeforeTheImporterReadsThem) {
  const auto said = [&](const std::string& library) {
    folder_.write("a.mtl", library);
    const std::string text =
        complaint("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    return text.substr(std::min(text.find(": "), text.size()));
  };
  // The importer writes where nothing is on the first of these.
  EXPECT_EQ(said("Kd 1 0 0\nPr 0.5\nmap_Kd none.png\nnewmtl a\n"), "");
  EXPECT_EQ(said("newmtl a\nKd 0.5\nPm 1\nd 0.5\nillum x\n"), "");
  EXPECT_EQ(said("newmtl a\nKd spectral a.rfl\n"), "");
  EXPECT_EQ(said("newmtl a\nKd 1 x 0\n"), ": a.mtl: line 2: Kd: \"x\" is not a number from 0");
  EXPECT_EQ(said("newmtl a\nPr nan\n"), ": a.mtl: line 2: Pr: \"nan\" is not a number from 0");
  EXPECT_EQ(said(std::string("newmtl a\0b\n", 11)), ": \"a.mtl\": not a text file");
}

TEST_F(ModelParts, NamesOfAModelReachNoTerminal) {
  Gltf g = triangle();
  g.json["meshes"][0]["name"] = std::string("a\x1b[31m\n\0b", 9);
  g.json["nodes"][0]["scale"] = {0, 0, 0};
  const std::string said = complaint("a.glb", g.bytes());
  EXPECT_NE(said.find("a\\x1b[31m\\n\\x00b"), said.npos) << said;
  const std::string statement = complaint("a.obj", "v\x1b]0;x 1 2\n");
  EXPECT_NE(statement.find("\"v\\x1b]0;x\""), statement.npos) << statement;
}

}  // namespace
}  // namespace taut::model_parts_test
