// The claim of a clip's proof: by the command, beside the clip and on its pictures.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/picture/picture.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

class Certified : public testing::Test {
 protected:
  void plan() {
    const ProgramResult found =
        run_taut({"plan", "swing.toml", "--tolerance", "1px", "--write", "-q"}, folder_.path());
    ASSERT_EQ(found.code, 0) << found.messages;
  }
  ProgramResult render(std::vector<std::string> more) {
    more.insert(more.begin(), {"render", "swing.toml", "--out", "clip", "--frames", "3", "--size",
                               "320x180", "--no-video", "--anew"});
    return run_taut(more, folder_.path());
  }
  nlohmann::json clip() const {
    return nlohmann::json::parse(read_file(folder_.path() / "clip" / "clip.json"));
  }
  picture::Picture picture() const {
    return picture::read_png(folder_.path() / "clip/frames/000003.png");
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", swing_scene(0.2));
};

TEST_F(Certified, ByItsPlan) {
  plan();
  const ProgramResult outcome = render({"--planned"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const std::string proof = clip().at("certificate");
  EXPECT_EQ(proof.rfind("within ", 0), 0u) << proof;
  EXPECT_NE(proof.find("px of the reference solution until 0.2 s"), std::string::npos) << proof;
  EXPECT_NE(outcome.messages.find("certificate: " + proof), std::string::npos) << outcome.messages;
}

TEST_F(Certified, SaysNothingWhereNobodyAsks) {
  const ProgramResult outcome = render({});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_FALSE(clip().contains("certificate"));
  EXPECT_EQ(outcome.messages.find("certificate"), std::string::npos) << outcome.messages;
}

TEST_F(Certified, OrSaysThatItIsNot) {
  const ProgramResult outcome = render({"--certificate"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const std::string proof = clip().at("certificate");
  EXPECT_EQ(proof.rfind("none", 0), 0u) << proof;
  EXPECT_NE(outcome.messages.find("certificate: none"), std::string::npos) << outcome.messages;
}

TEST_F(Certified, NotAtOtherFramesThanThePlans) {
  plan();
  const ProgramResult outcome = render({"--planned", "--fps", "40"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(clip().at("certificate"), "none: the plan is of 50 frames a second, the clip of 40");
}

TEST_F(Certified, OnThePictureWhereThatIsAskedFor) {
  ASSERT_EQ(render({}).code, 0);
  const picture::Picture plain = picture();
  ASSERT_EQ(render({"--certificate"}).code, 0);
  EXPECT_NE(picture().pixels, plain.pixels);
}

TEST_F(Certified, AReadOnlySceneIsRefusedBeforeAllWork) {
  fs::permissions(scene_, fs::perms::owner_read);
  const ProgramResult outcome =
      run_taut({"plan", "swing.toml", "--tolerance", "1px", "--write"}, folder_.path());
  EXPECT_EQ(outcome.code, 6);
  EXPECT_NE(outcome.messages.find("is read-only"), std::string::npos) << outcome.messages;
  EXPECT_EQ(outcome.output, "");
}

}  // namespace
}  // namespace taut
