// Where the files that scenes name are looked for, and what is said of the places.
#include <gtest/gtest.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

constexpr const char* kStill = "t,x,y,z\n0,0,1,0\n1,0,1,0\n";
constexpr const char* kBroken = "t,x,y,z\n0,1,2\n";

/// A scene that follows hand.csv, in a folder of its own, and folders that may have the file.
class AssetFolders : public testing::Test {
 protected:
  AssetFolders() {
    folder_.write("scenes/scene.toml", "duration = 1.0\n[paths.hand]\nfile = \"hand.csv\"\n");
    for (const char* name : {"first", "second"}) {
      std::filesystem::create_directories(folder_.path() / name);
    }
  }

  ProgramResult check(const std::string& variable, std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"env", "TAUT_ASSETS=" + variable, TAUT_PROGRAM, "check",
                                     (folder_.path() / "scenes/scene.toml").string()});
    return Child(options, folder_.path()).wait();
  }

  std::string at(const char* name) const { return (folder_.path() / name).string(); }

  Folder folder_;
};

TEST_F(AssetFolders, AreNamedWhereAFileIsInNone) {
  const ProgramResult outcome =
      check(at("first") + ":" + at("second"), {"--assets", folder_.path().string()});
  EXPECT_EQ(outcome.code, 3);
  std::string line = "there is no file \"hand.csv\"; looked: --assets (" + folder_.path().string() +
                     "), TAUT_ASSETS (" + at("first") + "), TAUT_ASSETS (" + at("second") +
                     "), beside the scene (" + at("scenes") + ")";
  EXPECT_NE(outcome.messages.find(line), std::string::npos) << outcome.messages;
}

TEST_F(AssetFolders, AreLookedIntoInTheirOrder) {
  EXPECT_EQ(check("").code, 3);
  folder_.write("second/hand.csv", kStill);
  EXPECT_EQ(check(at("first") + ":" + at("second")).code, 0);
  EXPECT_EQ(check("", {"--assets", at("second")}).code, 0);
  folder_.write("first/hand.csv", kBroken);
  EXPECT_EQ(check(at("first") + ":" + at("second")).code, 3);
  EXPECT_EQ(check(at("first"), {"--assets", at("second")}).code, 0);
  folder_.write("scenes/hand.csv", kBroken);
  EXPECT_EQ(check(at("second")).code, 0);
  EXPECT_EQ(check("").code, 3);
}

TEST_F(AssetFolders, KeepWhatIsOutsideOfThemOut) {
  folder_.write("hand.csv", kStill);
  std::filesystem::create_symlink("../hand.csv", folder_.path() / "first/hand.csv");
  const ProgramResult outcome = check(at("first"));
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("expected a file inside of " + at("first")), std::string::npos)
      << outcome.messages;
}

TEST_F(AssetFolders, MustBeThere) {
  const ProgramResult outcome = check("", {"--assets", at("third")});
  EXPECT_EQ(outcome.code, 2);
}

TEST_F(AssetFolders, AreNamedToWhoeverGivesAWholePath) {
  folder_.write("scenes/scene.toml",
                "duration = 1.0\n[paths.hand]\nfile = \"" + at("second") + "/hand.csv\"\n");
  const ProgramResult outcome = check(at("first"));
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("expected a path relative to one of: TAUT_ASSETS (" +
                                  at("first") + "), beside the scene (" + at("scenes") + ")"),
            std::string::npos)
      << outcome.messages;
}

}  // namespace
}  // namespace taut
