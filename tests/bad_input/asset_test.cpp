// Bad meshes, as a scene that names them meets them: the scene's place, the file and the cause.
#include <sys/stat.h>

#include <limits>

#include "tests/support/fault_table.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/unit/scenes/model_files.h"

namespace taut {
namespace {

// The place of the mesh in it is 8:8.
std::string scene(const std::string& mesh) {
  return "duration = 1.0\n[stage]\n"
         "[bodies.ball]\nmass = 1.0\nshape = { sphere = { diameter = 0.1 } }\n"
         "position = [0, 1, 0]\n\nmesh = \"" +
         mesh + "\"\n";
}

TEST(BadAsset, EveryFaultIsNamedWithItsPlace) {
  const Folder folder;
  const auto home = folder.path() / "home";
  FaultTable table("Meshes", home);
  const auto expect = [&](const char* name, const std::string& mesh, const char* says) {
    SCOPED_TRACE(name);
    folder.write("home/scene.toml", scene(mesh));
    const ProgramResult outcome = run_taut({"check", "scene.toml"}, home);
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(outcome.messages.rfind("taut: scene.toml:8:8: bodies.ball.mesh: ", 0), 0u)
        << outcome.messages;
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << outcome.messages;
    table.add(name, outcome);
  };
  const auto expect_file = [&](const char* name, const std::string& file, const std::string& bytes,
                               const char* says) {
    folder.write("home/" + file, bytes);
    expect(name, file, says);
  };
  const std::string whole = skinned().bytes();
  folder.write("home/good.glb", whole);
  folder.write("home/scene.toml", scene("good.glb"));
  EXPECT_EQ(run_taut({"check", "scene.toml"}, home).code, 0);

  expect("missing", "no.glb", "there is no file");
  folder.write("outside.glb", whole);
  expect("climbing out", "../outside.glb", "expected a file inside of");
  expect("absolute", "/etc/passwd", "a path relative to one of: ");
  std::filesystem::create_directory(home / "folder.glb");
  expect("a directory", "folder.glb", "not a directory");
  expect_file("empty", "a.glb", "", "empty file");
  expect_file("truncated", "a.glb", whole.substr(0, whole.size() / 2), "a.glb");
  expect_file("another format", "a.fbx", "x", "expected .glb, .gltf, .obj or .bvh");
  folder.write("home/big.glb", "glTF");
  std::filesystem::resize_file(home / "big.glb", std::uintmax_t{1} << 30);  // sparse
  expect("sparse, 1 GiB", "big.glb", "larger than");
  {
    Gltf g = skinned();
    g.binary[36] = 9;
    expect_file("index out of range", "a.glb", g.bytes(), "has index 9");
  }
  {
    Gltf g = skinned();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    g.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
        g.add<float>({0, nan, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
    expect_file("NaN vertex", "a.glb", g.bytes(), "is not finite");
  }
  {
    Gltf g = skinned();
    g.json["skins"][0]["joints"] = std::vector<int>(257, 1);
    expect_file("too many bones", "a.glb", g.bytes(), "expected 1 to 256");
  }
  {
    Gltf g = skinned();
    g.json["asset"] = nlohmann::json::array();
    expect_file("asset is a list", "a.glb", g.bytes(), "its asset must be an object");
  }
  {
    Gltf g = triangle();
    auto& primitives = g.json["meshes"][0]["primitives"];
    const auto one = primitives[0];
    for (int i = 1; i < 100'000; ++i) primitives.push_back(one);
    expect_file("100,000 primitives", "a.glb", g.bytes(), "more than 4096");
  }
  {
    Gltf g = triangle();
    for (std::size_t i = 1; i < 60'000; ++i) {
      g.json["nodes"].push_back({{"mesh", 0}});
      g.json["scenes"][0]["nodes"].push_back(i);
    }
    expect_file("60,000 nodes that show one mesh", "a.glb", g.bytes(), "more than 4096");
  }
  std::string groups = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 100'000; ++i) groups += "g n\nf 1 2 3\n";
  expect_file("100,000 groups", "a.obj", groups, "more than 4096");
  mkfifo((home / "pipe.glb").c_str(), 0600);
  expect("a pipe", "pipe.glb", "is a pipe");
  std::filesystem::create_symlink("pipe.glb", home / "a.mtl");
  expect_file("materials from a pipe", "b.obj",
              "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "is a pipe");
  folder.write("outside.bin", triangle().binary);
  const auto expect_buffer = [&](const char* name, const std::string& uri, const char* says) {
    Gltf g = triangle();
    g.json["buffers"][0]["uri"] = uri;
    expect_file(name, "a.gltf", g.json.dump(), says);
  };
  expect_buffer("a buffer outside", "../outside.bin", "leads out of");
  expect_buffer("the same, encoded", "%2e%2e%2Foutside.bin", "leads out of");
  std::filesystem::create_symlink("../outside.bin", home / "link.bin");
  expect_buffer("a buffer by a link", "link.bin", "is a link that leads out of");
  expect_buffer("a buffer from a root", "file:///etc/passwd", "expected the name of a file");
  expect_buffer("a buffer that is not there", "none.bin", "there is no such file");
  expect_file("materials outside", "c.obj", "mtllib ../a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
              "leads out of");
  {
    Gltf g = triangle();
    g.json["meshes"][0]["name"] = std::string("\x1b[31m\n\0x", 8);
    g.json["nodes"][0]["scale"] = {0, 0, 0};
    expect_file("a name of control characters", "a.glb", g.bytes(), "\\x1b[31m\\n\\x00x");
  }
  EXPECT_TRUE(table.is_as_accepted());
}

TEST(BadAsset, WhatIsLeftOutOfAModelIsAWarning) {
  const Folder folder;
  folder.write("scene.toml", scene("a.obj"));
  folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 2\n");
  const char* says = "warning: a.obj: left out: lines (1 statement \"l\", first in line 5)\n";
  const ProgramResult checked = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.messages;
  EXPECT_NE(checked.output.find(says), std::string::npos) << checked.output;
  const ProgramResult exported = run_taut({"export", "scene.toml", "-o", "a.glb"}, folder.path());
  EXPECT_EQ(exported.code, 0) << exported.messages;
  EXPECT_NE(exported.messages.find(says), std::string::npos) << exported.messages;
}

TEST(BadAsset, ASceneWithoutAStageIsNoBetter) {
  const Folder folder;
  folder.write("a.glb", "");
  std::string text = scene("a.glb");
  text.erase(text.find("[stage]\n"), 8);
  folder.write("scene.toml", text);
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(outcome.messages, "taut: scene.toml:7:8: bodies.ball.mesh: a.glb: empty file\n");
}

TEST(BadAsset, ACharacterWithoutBones) {
  const Folder folder;
  FaultTable table("Characters", folder.path());
  folder.write("ball.glb", triangle().bytes());
  folder.write("scene.toml", R"(duration = 1.0
[stage]
[paths.hand]
keys = [{ t = 0, position = [0, 1, 0] }]
[characters.player]
mesh = "ball.glb"
right_hand = "hand"
)");
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(outcome.messages.rfind("taut: scene.toml:6:8: characters.player.mesh: ", 0), 0u)
      << outcome.messages;
  table.add("no bones", outcome);
  // Commands that draw no picture of it say so, too.
  const auto expect = [&](const char* name, const std::string& character, const char* says) {
    folder.write("scene.toml",
                 "duration = 0.1\n[paths.hand]\nkeys = [{ t = 0, position = [0, 1, 0] }]\n"
                 "[characters.player]\n" +
                     character);
    const ProgramResult simulated = run_taut({"simulate", "scene.toml"}, folder.path());
    EXPECT_EQ(simulated.code, 3);
    EXPECT_EQ(simulated.output, "");
    EXPECT_NE(simulated.messages.find(says), std::string::npos) << simulated.messages;
    table.add(name, simulated);
  };
  expect("no bones, simulated", "mesh = \"ball.glb\"\nright_hand = \"hand\"\n",
         "scene.toml:5:8: characters.player.mesh: ball: has no bones Hips, Spine, Head, LeftArm");
  const std::string mesh = "mesh = \"ball.glb\"\nright_hand = \"hand\"\n";
  expect(
      "names of nobody", mesh + "bones = \"maximo\"\n",
      "scene.toml:7:9: characters.player.bones: found \"maximo\", expected a table of strings, or "
      "one of: mixamo, did you mean \"mixamo\"?");
  expect(
      "a bone that no figure has", mesh + "bones = { RightHnad = \"hand_r\" }\n",
      "scene.toml:7:11: characters.player.bones.RightHnad: found \"RightHnad\", expected the name "
      "of a bone, did you mean \"RightHand\"?");
  expect("a bone that the model lacks",
         mesh + "bones = { RightHand = \"hand_r\", Head = \"head\" }\n",
         "scene.toml:7:9: characters.player.bones: ball: has no bones \"hand_r\", \"head\"");
  expect("an animation that nobody has", "mesh = \"ball.glb\"\nanimation = {}\n",
         "scene.toml:6:13: characters.player.animation: ball has no animation that moves it");
  expect("a path and an animation", mesh + "animation = {}\n", "right_hand, animation");
  folder.write("broken.bvh", "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0\n}\n");
  expect("broken motion capture", "mesh = \"broken.bvh\"\nanimation = {}\n",
         "broken.bvh: line 5: found \"}\", expected a number");
  expect("no such path", "mesh = \"ball.glb\"\nright_hand = \"hnad\"\n",
         "scene.toml:6:14: characters.player.right_hand: found \"hnad\"");
  expect("head that goes back in time",
         "mesh = \"ball.glb\"\nright_hand = \"hand\"\n"
         "head = [{ t = 1, yaw = 1 }, { t = 0.5 }]\n",
         "scene.toml:7:35: characters.player.head[1].t: found 0.5, expected a time after 1 s");
  EXPECT_TRUE(table.is_as_accepted());
}

}  // namespace
}  // namespace taut
