// Models that must be refused: every error names the file and its cause, nothing crashes.
#include <sys/stat.h>

#include <functional>
#include <random>

#include "model_files.h"
#include "scenes/files/error.h"
#include "scenes/model/load_model.h"

namespace taut::model_broken {
namespace {

using nlohmann::json;
using ModelBroken = ModelFiles;

/// In this process: some thousand files are read, and a sanitizer sees what happens.
std::string complaint_about(const std::filesystem::path& file) {
  try {
    scenes::load_model_here(file);
  } catch (const scenes::BadAsset& error) {
    return error.what();
  }
  return "accepted";
}

TEST_F(ModelBroken, FilesThatAreNoModel) {
  const auto expect = [&](const std::filesystem::path& file, const std::string& cause) {
    EXPECT_EQ(complaint_about(file), file.string() + ": " + cause);
  };
  expect(folder_ / "no.glb", "cannot be opened: No such file or directory");
  std::filesystem::create_directory(folder_ / "dir.glb");
  expect(folder_ / "dir.glb", "is a directory, expected a model");
  mkfifo((folder_ / "pipe.glb").c_str(), 0600);
  expect(folder_ / "pipe.glb", "is a pipe, expected a model");
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.glb");
  expect(folder_ / "zero.glb", "is a device, expected a model");
  expect(write("empty.glb", ""), "empty file");
  expect(write("a.fbx", "x"), "is a \".fbx\" file, expected .glb, .gltf, .obj or .bvh");
  expect(write("text.glb", "hello"), "not a GLB file: it does not start with \"glTF\"");
  std::filesystem::resize_file(write("big.glb", "glTF"), (64u << 20) + 1);
  expect(folder_ / "big.glb", "is larger than 64 MiB, expected a model");
  expect(write("a.obj", "v 0 0 0\n"), "has no faces");
  expect(write("b.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"), "line 3: index 3, but there are 2 so far");
  expect(write("c.obj", "v 0 nan 0\n"), "line 1: \"nan\" is not a number");
  expect(write("d.obj", "v 0 0\n"), "line 1: 2 numbers after v, expected 3 to 7");
  expect(write("e.obj", "curb 0 1 2\n"), "line 1: unknown statement \"curb\"");
}

TEST_F(ModelBroken, EveryTruncationIsRefused) {
  const std::string whole = skinned().bytes();
  for (std::size_t size = 1; size < whole.size(); size += 3)
    EXPECT_NE(complaint_about(write("cut.glb", whole.substr(0, size))), "accepted") << size;
}

struct Fault {
  const char* cause;  // a part of the message
  std::function<void(Gltf&)> make;
};

TEST_F(ModelBroken, StructuresThatLie) {
  const auto primitive = [](Gltf& g) -> json& { return g.json["meshes"][0]["primitives"][0]; };
  const auto add_nan = [&](Gltf& g) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    primitive(g)["attributes"]["POSITION"] =
        g.add<float>({0, nan, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  };
  const Fault faults[] = {
      {"asset.version", [](Gltf& g) { g.json["asset"]["version"] = "1.0"; }},
      {"extension", [](Gltf& g) { g.json["extensionsRequired"] = {"KHR_draco"}; }},
      {"its scene is empty", [](Gltf& g) { g.json.erase("scenes"), g.json.erase("nodes"); }},
      {"two parents", [](Gltf& g) { g.json["nodes"][3]["children"] = {1}; }},
      {"must be an array", [](Gltf& g) { g.json["nodes"] = 7; }},
      {"expected an index below 4", [](Gltf& g) { g.json["nodes"][1]["children"] = {99}; }},
      {"truncated: buffers[0]", [](Gltf& g) { g.json["buffers"][0]["byteLength"] = 1 << 20; }},
      {"beyond its buffer", [](Gltf& g) { g.json["bufferViews"][0]["byteLength"] = 1 << 20; }},
      {"beyond its bufferView", [](Gltf& g) { g.json["accessors"][0]["count"] = 4; }},
      {"is empty", [](Gltf& g) { g.json["accessors"][0]["count"] = 0; }},
      {"must be a whole number", [](Gltf& g) { g.json["accessors"][0]["count"] = -3; }},
      {"too large", [](Gltf& g) { g.json["accessors"][0]["count"] = 1ull << 63; }},
      {"type is unknown", [](Gltf& g) { g.json["accessors"][0]["type"] = "VEC5"; }},
      {"is not aligned", [](Gltf& g) { g.json["bufferViews"][0]["byteOffset"] = 2; }},
      {"sparse", [](Gltf& g) { g.json["accessors"][0]["sparse"] = json::object(); }},
      {"has index 9", [](Gltf& g) { g.binary[36] = 9; }},
      {"names joint 9",
       [&](Gltf& g) {
         primitive(g)["attributes"]["JOINTS_0"] =
             g.add<std::uint8_t>({9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC4", 4);
       }},
      {"broken weight",
       [&](Gltf& g) {
         primitive(g)["attributes"]["WEIGHTS_0"] = g.add<float>(
             std::vector<float>(12, std::numeric_limits<float>::infinity()), 5126, "VEC4", 4);
       }},
      {"is not read",  // weights in normalised bytes
       [&](Gltf& g) {
         primitive(g)["attributes"]["WEIGHTS_0"] =
             g.add<std::uint8_t>(std::vector<std::uint8_t>(12, 255), 5121, "VEC4", 4);
       }},
      {"is not finite", add_nan},
      {"expected 1 to 256",
       [](Gltf& g) { g.json["skins"][0]["joints"] = std::vector<int>(257, 1); }},
      {"must be 2 float matrices", [](Gltf& g) { g.json["accessors"].back()["count"] = 1; }},
      {"is scaled",
       [](Gltf& g) {
         g.json["nodes"][1]["scale"] = {-2, 2, 2};
       }},
      {"is not a unit",
       [](Gltf& g) {
         g.json["nodes"][1]["rotation"] = {0, 0, 0, 0};
       }},
      {"roughness",
       [](Gltf& g) { g.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = -1; }},
      {"has no triangles", [&](Gltf& g) { primitive(g)["mode"] = 0; }},
      {"must have both", [&](Gltf& g) { primitive(g)["attributes"].erase("WEIGHTS_0"); }},
      {"expected the name of a file",
       [](Gltf& g) { g.json["buffers"][0]["uri"] = "http://example.org/a.bin"; }},
  };
  for (const Fault& fault : faults) {
    Gltf g = skinned();
    fault.make(g);
    const auto file = write("fault.glb", g.bytes());
    const std::string message = complaint_about(file);
    EXPECT_NE(message.find(fault.cause), std::string::npos) << fault.cause << "\n" << message;
    EXPECT_EQ(message.compare(0, file.string().size(), file.string()), 0) << message;
  }
}

TEST_F(ModelBroken, ValuesOfAnotherTypeAreRefusedOrPassedOver) {
  const json others[] = {json::array(), json::object(), "x", 1.5, -1, true, nullptr};
  const json values = skinned().json.flatten();
  for (const auto& value : values.items()) {
    // The value, and all that it stands in.
    for (std::string at = value.key(); !at.empty(); at.resize(at.rfind('/'))) {
      for (const json& other : others) {
        Gltf g = skinned();
        g.json[json::json_pointer(at)] = other;
        EXPECT_NO_THROW(complaint_about(write("typed.glb", g.bytes()))) << at << other;
      }
    }
  }
  Gltf g = skinned();
  g.json["asset"] = json::array();
  const auto file = write("asset.glb", g.bytes());
  EXPECT_EQ(complaint_about(file), file.string() + ": its asset must be an object");
}

TEST_F(ModelBroken, MorePiecesThanAnybodyDrawsAreRefused) {
  const auto refused = [&](const std::filesystem::path& file, const std::string& says) {
    EXPECT_EQ(complaint_about(file), file.string() + ": " + says);
  };
  Gltf primitives = triangle();
  json& list = primitives.json["meshes"][0]["primitives"];
  const json one = list[0];
  for (int i = 1; i < 100'000; ++i) list.push_back(one);
  refused(write("primitives.glb", primitives.bytes()), "more than 4096 primitives");
  Gltf nodes = triangle();
  for (std::size_t i = 1; i < 60'000; ++i) {
    nodes.json["nodes"].push_back({{"mesh", 0}});
    nodes.json["scenes"][0]["nodes"].push_back(i);
  }
  refused(write("nodes.glb", nodes.bytes()), "its nodes show more than 4096 primitives");
  for (const std::string word : {"g", "o", "usemtl"}) {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < 100'000; ++i) text += word + " n" + std::to_string(i) + "\nf 1 2 3\n";
    refused(write("groups.obj", text), "line 8196: more than 4096 statements \"" + word + "\"");
  }
}

TEST_F(ModelBroken, LibrariesOfMaterialsAreRegularFilesBesideIt) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  mkfifo((folder_ / "pipe.mtl").c_str(), 0600);
  const auto complaint = [&](const std::string& library) {
    return complaint_about(write("a.obj", "mtllib " + library + "\n" + triangle));
  };
  EXPECT_EQ(complaint("none.mtl"), "accepted");
  write("whole.mtl", "newmtl Brass\nKd 1 0.5 0\n");
  EXPECT_EQ(complaint("whole.mtl"), "accepted");
  EXPECT_NE(
      complaint("pipe.mtl")
          .find("a.obj: line 1: mtllib \"pipe.mtl\": is a pipe, expected a library of materials"),
      std::string::npos)
      << complaint("pipe.mtl");
  EXPECT_NE(complaint("../../etc/passwd").find("leads out of " + folder_.string()),
            std::string::npos)
      << complaint("../../etc/passwd");
}

TEST_F(ModelBroken, DeepNestingIsRefused) {
  const std::string deep(100000, '[');
  EXPECT_NE(complaint_about(write("deep.gltf", deep)).find("nested more than"), std::string::npos);
  Gltf g = triangle();
  for (int i = 0; i < 1000; ++i) {
    g.json["nodes"].back()["children"] = {i + 1};
    g.json["nodes"].push_back({{"name", "n" + std::to_string(i)}});
  }
  EXPECT_NE(complaint_about(write("deep.glb", g.bytes())).find("nested more than"),
            std::string::npos);
}

TEST_F(ModelBroken, DamagedBytesNeverCrash) {
  std::mt19937 random(1);
  const std::string whole = skinned().bytes();
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n";
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = round % 3 ? whole : text;
    for (unsigned damage = 0; damage < 1 + random() % 4; ++damage)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    complaint_about(write(round % 3 ? "damaged.glb" : "damaged.obj", bytes));
  }
}

}  // namespace
}  // namespace taut::model_broken
