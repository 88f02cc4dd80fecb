// The files that models name: those of the project, and no other.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "scenes/files/error.h"
#include "scenes/files/files.h"
#include "scenes/model/load_model.h"
#include "scenes/model/named_files.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut::model_reach_test {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

/// A project with a folder of models, and a secret beside the project.
class ModelReach : public testing::Test {
 protected:
  ModelReach() {
    folder_.write("secret.bin", triangle().binary);
    folder_.write("project/shared/data.bin", triangle().binary);
    folder_.write("project/models/my data.bin", triangle().binary);
    root_ = fs::canonical(folder_.path() / "project");
  }

  /// What is said of a model whose buffer is at `uri`.
  std::string complaint(const std::string& uri) const {
    Gltf g = triangle();
    g.json["buffers"][0]["uri"] = uri;
    folder_.write("project/models/a.gltf", g.json.dump());
    return complaint_about("a.gltf");
  }
  std::string complaint_about(const std::string& name) const {
    const fs::path file = root_ / "models" / name;
    std::string said[2];
    for (const bool here : {false, true}) {
      try {
        here ? scenes::load_model_here(file, root_) : scenes::load_model(file, root_);
      } catch (const scenes::BadAsset& error) {
        said[here] = error.what();
      }
    }
    EXPECT_EQ(said[0], said[1]);
    return said[0];
  }
  void link(const fs::path& target, const std::string& name) const {
    fs::create_symlink(target, root_ / name);
  }

  Folder folder_;
  fs::path root_;
};

TEST_F(ModelReach, FilesOfTheProjectAreRead) {
  link("my data.bin", "models/link.bin");
  link("../shared", "models/folder");
  link(root_ / "shared/data.bin", "models/whole.bin");
  link("link.bin", "models/chain.bin");
  folder_.write("project/models/50%.bin", triangle().binary);
  folder_.write("project/models/%20.bin", triangle().binary);
  for (const char* uri : {"my data.bin", "my%20data.bin", "./my%20data.bin", "../shared/data.bin",
                          "%2e%2e%2Fshared%2fdata.bin", "..\\shared\\data.bin", "link.bin",
                          "chain.bin", "folder/data.bin", "folder/../models/link.bin", "whole.bin",
                          "50%.bin", "50%25.bin", "%2520.bin", "../models/../shared/./data.bin"}) {
    EXPECT_EQ(complaint(uri), "") << uri;
  }
}

TEST_F(ModelReach, OthersAreRefused) {
  link(folder_.path() / "secret.bin", "models/out.bin");
  link("../../secret.bin", "models/up.bin");
  link("../..", "models/above");
  link("up.bin", "models/chain.bin");
  link("loop.bin", "models/loop.bin");
  link("/dev/zero", "models/zero.bin");
  mkfifo((root_ / "models/pipe.bin").c_str(), 0600);
  const std::string start = (root_ / "models/a.gltf: buffers[0].uri \"").string();
  const auto expect = [&](const std::string& uri, const std::string& says) {
    EXPECT_EQ(complaint(uri), start + uri + "\": " + says);
  };
  const std::string out = "leads out of " + root_.string(), linked = "is a link that " + out;
  expect("../../secret.bin", out);
  expect("../../../../../../../../../../etc/passwd", out);
  expect("%2e%2e/%2e%2e/secret.bin", out);
  expect("..%2f..%2fsecret.bin", out);
  expect("..%5c..%5Csecret.bin", out);
  expect("../shared/../../secret.bin", out);
  expect("out.bin", linked);
  expect("up.bin", linked);
  expect("chain.bin", linked);
  expect("above/secret.bin", linked);
  expect("above/project/shared/data.bin", linked);
  expect("zero.bin", linked);
  expect("loop.bin", "is a chain of more than 40 links");
  expect("pipe.bin", "is a pipe, expected a buffer");
  expect("../shared", "is a directory, expected a buffer");
  expect("none.bin", "there is no such file");
  expect("%252e%252e/%252e%252e/secret.bin", "there is no such file");  // decoded once
  const std::string relative = "expected the name of a file, relative to the model's folder";
  for (const char* uri : {"/etc/passwd", "%2fetc/passwd", "//host/share", "file:///etc/passwd",
                          "FILE:passwd", "http://localhost/a", "C:\\\\a.bin", "a%00b", ""}) {
    const std::string said = complaint(uri);
    EXPECT_NE(said.find(relative), said.npos) << uri << '\n' << said;
  }
  EXPECT_EQ(scenes::name_of_uri("my%20data.bin%00"), std::nullopt);
}

TEST_F(ModelReach, ALinkedModelStaysInTheProject) {
  folder_.write("outside.glb", triangle().bytes());
  folder_.write("project/shared/inside.glb", triangle().bytes());
  link("../shared/inside.glb", "models/inside.glb");
  link("../../outside.glb", "models/outside.glb");
  EXPECT_EQ(complaint_about("inside.glb"), "");
  const std::string said = complaint_about("outside.glb");
  EXPECT_NE(said.find("outside.glb: leads out of " + root_.string()), said.npos) << said;
}

TEST_F(ModelReach, LibrariesOfMaterialsAndTheirPicturesToo) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  folder_.write("secret.mtl", "newmtl a\n");
  folder_.write("project/models/climbs.mtl", "newmtl a\nmap_Kd ../../secret.png\n");
  folder_.write("project/models/whole.mtl", "newmtl a\nmap_Kd C:\\a.png\n");
  const auto said = [&](const std::string& library) {
    folder_.write("project/models/a.obj", "mtllib " + library + "\n" + triangle);
    const std::string start = (root_ / "models/a.obj: ").string(), text = complaint_about("a.obj");
    EXPECT_EQ(text.substr(0, start.size()), start);
    return text.substr(std::min(start.size(), text.size()));
  };
  EXPECT_EQ(said("../../secret.mtl"),
            "line 1: mtllib \"../../secret.mtl\": leads out of " + root_.string());
  EXPECT_NE(said("/etc/passwd").find("expected the name of a file"), std::string::npos);
  EXPECT_EQ(said("climbs.mtl"),
            "climbs.mtl: line 2: map_Kd \"../../secret.png\": leads out of " + root_.string());
  EXPECT_NE(said("whole.mtl").find("expected the name of a file"), std::string::npos);
}

/// Its way is followed folder by folder, each from the one before.
TEST_F(ModelReach, ReadBeneathNeverLeavesItsFolder) {
  const auto read = [&](const fs::path& name) {
    return scenes::read_beneath(root_, name, 1 << 20, "a file", "it");
  };
  EXPECT_TRUE(read("shared/data.bin"));
  EXPECT_TRUE(read(root_ / "shared/data.bin"));
  EXPECT_FALSE(read("shared/none"));
  EXPECT_FALSE(read("shared/data.bin/none"));
  EXPECT_THROW(read(".."), scenes::BadAsset);
  EXPECT_THROW(read("."), scenes::BadAsset);
  EXPECT_THROW(read("/"), scenes::BadAsset);
  EXPECT_THROW(read(root_.string() + "s/data.bin"), scenes::BadAsset);
  EXPECT_THROW(read(std::string(5000, 'a')), scenes::BadAsset);
  std::string deep;
  for (int i = 0; i < 200; ++i) deep += "a/";
  fs::create_directories(root_ / deep);
  EXPECT_THROW(read(deep + "b"), scenes::BadAsset);
}

}  // namespace
}  // namespace taut::model_reach_test
