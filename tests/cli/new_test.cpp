// taut new: scenes to begin with, and the pages that show the shipped ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const fs::path kShipped = fs::path(TAUT_SOURCE_DIR) / "scenes";

class NewScene : public testing::Test {
 protected:
  ProgramResult run(const std::vector<std::string>& words) const {
    return run_taut(words, folder_.path());
  }
  std::string text(const std::string& file) const { return read_file(folder_.path() / file); }

  Folder folder_;
};

TEST_F(NewScene, OfEveryKindHasNoWarningAndRenders) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(kShipped / "new")) {
    const std::string kind = entry.path().stem();
    ASSERT_EQ(run({"new", kind, "--like", kind, "-q"}).output, kind + ".toml\n");
    EXPECT_EQ(text(kind + ".toml"), read_file(entry.path()));
    EXPECT_LE(std::ranges::count(text(kind + ".toml"), '\n'), 30) << kind;
    files.push_back(kind + ".toml");
  }
  EXPECT_EQ(files.size(), 6u);
  std::vector<std::string> check{"check", "--json"},
      render{"render",    "--frames", "3",          "--size",        "96x54",
             "--samples", "1",        "--no-video", "--no-estimate", "-q"};
  check.insert(check.end(), files.begin(), files.end());
  render.insert(render.end(), files.begin(), files.end());
  const ProgramResult checked = run(check);
  ASSERT_EQ(checked.code, 0) << checked.messages;
  for (const nlohmann::json& one : nlohmann::json::parse(checked.output)) {
    for (const std::string text : one.at("warnings")) {
      // A slow machine does not simulate all that the camera shows in the time that check has.
      EXPECT_NE(text.find("is left out: "), std::string::npos) << one.at("scene") << text;
    }
  }
  const ProgramResult rendered = run(render);
  EXPECT_EQ(rendered.code, 0) << rendered.messages;
  for (const std::string& file : files)
    EXPECT_TRUE(fs::exists(folder_.path() / "out" / fs::path(file).stem() / "frames/000003.png"))
        << file;
}

TEST_F(NewScene, KeepsAFileThatIsThere) {
  folder_.write("mine.toml", "mine");
  const ProgramResult kept = run({"new", "mine"});
  EXPECT_EQ(kept.code, 6);
  EXPECT_NE(kept.messages.find("mine.toml: is there already"), std::string::npos) << kept.messages;
  EXPECT_EQ(text("mine.toml"), "mine");
  EXPECT_EQ(run({"new", "mine", "--anew", "-q"}).code, 0);
  EXPECT_EQ(text("mine.toml"), read_file(kShipped / "new/rope.toml"));
  fs::create_symlink("nowhere.toml", folder_.path() / "link.toml");
  EXPECT_EQ(run({"new", "link"}).code, 6);
  EXPECT_FALSE(fs::exists(folder_.path() / "nowhere.toml"));
}

TEST_F(NewScene, GoesWhereItsNameSays) {
  EXPECT_EQ(run({"new", "far/away/swing.toml", "-q"}).output, "far/away/swing.toml\n");
  EXPECT_TRUE(fs::exists(folder_.path() / "far/away/swing.toml"));
  EXPECT_EQ(run({"new", "-"}).output, read_file(kShipped / "new/rope.toml"));
  EXPECT_FALSE(fs::exists(folder_.path() / "-.toml"));
  const ProgramResult told = run({"new", "net", "--like", "net", "--json"});
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  EXPECT_EQ(schema.complaint(nlohmann::json::parse(told.output), "new"), "");
}

TEST_F(NewScene, SaysWhyItCannotBeWritten) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"new"},
                                                {"new", "far/"},
                                                {"new", "."},
                                                {"new", ""},
                                                {"new", "-", "--json"},
                                                {"new", "swing", "--like", "robe"}})
    EXPECT_EQ(run(words).code, 2) << words.back();
  folder_.write("file", "");
  EXPECT_EQ(run({"new", "file/swing"}).code, 6);
  EXPECT_EQ(run({"new", "/proc/swing"}).code, 6);
  fs::copy(TAUT_PROGRAM, folder_.path() / "taut");  // without the scenes that come with it
  const ProgramResult alone = Child({"./taut", "new", "swing"}, folder_.path()).wait();
  EXPECT_EQ(alone.code, 3);
  EXPECT_NE(alone.messages.find("there is no file \"scenes/new/rope.toml\"; looked: "),
            std::string::npos)
      << alone.messages;
  EXPECT_FALSE(fs::exists(folder_.path() / "swing.toml"));
}

/// The links of a page that end so, as paths from scenes/.
std::set<std::string> linked(const fs::path& page, const std::string& ending) {
  const std::string text = read_file(page);
  std::set<std::string> files;
  for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 2)) {
    const std::string file = text.substr(at + 2, text.find(')', at) - at - 2);
    if (file.ends_with(ending))
      files.insert(fs::relative(fs::weakly_canonical(page.parent_path() / file), kShipped));
  }
  return files;
}

TEST(Gallery, ShowsEveryShippedScene) {
  std::set<std::string> scenes, pictures;
  for (const auto& entry : fs::recursive_directory_iterator(kShipped)) {
    if (entry.path().extension() != ".toml") continue;
    std::string name = fs::relative(entry.path(), kShipped);
    scenes.insert(name);
    std::ranges::replace(name, '/', '_');
    pictures.insert("../assets/pictures/scenes/" + name.replace(name.size() - 5, 5, ".webp"));
  }
  EXPECT_EQ(linked(kShipped / "gallery/README.md", ".toml"), scenes);
  EXPECT_EQ(linked(kShipped / "gallery/README.md", ".webp"), pictures);
  std::uintmax_t size = 0;
  for (const std::string& picture : pictures) size += fs::file_size(kShipped / picture);
  EXPECT_LT(size, 1'500'000u);
}

TEST(Tutorial, HasTenStepsFromANewScene) {
  const std::set<std::string> steps = linked(kShipped / "tutorial/README.md", ".toml");
  EXPECT_EQ(steps.size(), 10u);
  EXPECT_TRUE(steps.contains("new/rope.toml"));
}

}  // namespace
}  // namespace taut
