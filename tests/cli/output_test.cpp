// The form of a clip's output: kinds of files, opacity, backgrounds, and the files' own
// descriptions.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "render/picture/picture.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

// Without a stage.
class Output : public testing::Test {
 protected:
  ProgramResult render(std::vector<std::string> more) const {
    more.insert(more.begin(), {"render", "swing.toml"});
    return run_taut(more, folder_.path());
  }
  nlohmann::json probe(const std::string& name) const {
    const ProgramResult outcome = Child({"ffprobe", "-v", "error", "-count_frames", "-show_streams",
                                         "-show_format", "-of", "json", name},
                                        folder_.path())
                                      .wait();
    return nlohmann::json::parse(outcome.output);
  }
  picture::Picture picture(const std::string& name) const {
    return picture::read_png(folder_.path() / name);
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kShortSwing);
};

TEST_F(Output, ASceneWithoutAStageIsSeen) {
  ASSERT_EQ(render({"-o", "poster.png", "--poster", "0"}).code, 0);
  const picture::Picture seen = picture("poster.png");
  EXPECT_EQ(seen.width, 96);
  // Hemp is redder than the ground, and the cove behind is darker.
  int hemp = 0, behind = 0, ground = 0;
  for (int y = 0; y < seen.height; ++y) {
    for (int x = 0; x < seen.width; ++x) {
      hemp += seen.at(x, y)[0] > seen.at(x, y)[2] + 20;
      if (y < seen.height / 4) behind += seen.at(x, y)[1];
      if (y >= seen.height - seen.height / 4) ground += seen.at(x, y)[1];
    }
  }
  EXPECT_GT(hemp, 15);
  EXPECT_LT(1.05 * behind, ground);
}

TEST_F(Output, EveryKindOfFile) {
  for (const auto& [name, codec] :
       std::vector<std::pair<std::string, std::string>>{{"a.mp4", "h264"},
                                                        {"a.webm", "vp9"},
                                                        {"a.mov", "prores"},
                                                        {"a.gif", "gif"},
                                                        {"a.apng", "apng"}}) {
    const ProgramResult outcome = render({"-o", name, "-q"});
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
    EXPECT_EQ(outcome.output, name + "\n");
    const nlohmann::json stream = probe(name).at("streams").at(0);
    EXPECT_EQ(stream.at("codec_name"), codec);
    EXPECT_EQ(stream.at("nb_read_frames"), "4") << name;
  }
  ASSERT_EQ(render({"-o", "a.webp", "-q"}).code, 0);
  const std::string webp = read_file(folder_.path() / "a.webp");
  EXPECT_EQ(webp.substr(8, 4), "WEBP");
  std::size_t frames = 0;
  for (std::size_t at = 0; (at = webp.find("ANMF", at)) != std::string::npos; ++at) ++frames;
  EXPECT_EQ(frames, 4u);
}

TEST_F(Output, QualityIsSize) {
  ASSERT_EQ(render({"-o", "low.mp4", "--quality", "10", "-q"}).code, 0);
  ASSERT_EQ(render({"-o", "high.mp4", "--quality", "100", "-q"}).code, 0);
  EXPECT_LT(fs::file_size(folder_.path() / "low.mp4"), fs::file_size(folder_.path() / "high.mp4"));
}

TEST_F(Output, PresetsAreSizes) {
  ASSERT_EQ(render({"-o", "draft.png", "--preset", "draft"}).code, 0);
  EXPECT_EQ(picture("draft.png").width, 640);
  EXPECT_EQ(picture("draft.png").height, 360);
}

TEST_F(Output, APreviewIsSmallAndStandsApart) {
  ASSERT_EQ(render({"--preview", "--no-video", "--out", "clip"}).code, 0);
  EXPECT_EQ(picture::read_png(folder_.path() / "clip/preview/frames/000000.png").width, 480);
  EXPECT_FALSE(fs::exists(folder_.path() / "clip/frames"));
  const auto record = nlohmann::json::parse(read_file(folder_.path() / "clip/preview/clip.json"));
  EXPECT_LE(record.at("fps"), 24);
  EXPECT_FALSE(record.contains("error_estimate_m") && record.at("error_estimate_m").is_number());
}

TEST_F(Output, ABackgroundComesOutAsItIsAsked) {
  ASSERT_EQ(
      render({"-o", "green.png", "--set", "stage.background=[0,1,0]", "--set", "stage.scenery=[]"})
          .code,
      0);
  const picture::Picture green = picture("green.png");
  EXPECT_EQ(green.at(1, 1)[0], 0);
  EXPECT_EQ(green.at(1, 1)[1], 255);
  EXPECT_EQ(green.at(1, 1)[2], 0);
}

TEST_F(Output, TransparentPicturesHaveNoBackgroundAndNoScenery) {
  const std::vector<std::string> bare = {"--transparent", "--set", "connectors.rope.diameter=0.03"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), bare.begin(), bare.end());
    return render(words);
  };
  ASSERT_EQ(with({"-o", "clear.png", "--poster", "0"}).code, 0);
  const picture::Picture clear = picture("clear.png");
  int solid = 0, nothing = 0;
  for (int y = 0; y < clear.height; ++y)
    for (int x = 0; x < clear.width; ++x) {
      solid += clear.at(x, y)[3] == 255;
      nothing += clear.at(x, y)[3] == 0;
    }
  EXPECT_EQ(clear.at(0, 0)[3], 0);
  EXPECT_GT(solid, 50);
  EXPECT_GT(nothing, clear.width * clear.height / 2);
  for (const char* name : {"clear.webm", "clear.mov", "clear.apng"})
    EXPECT_EQ(with({"-o", name, "-q"}).code, 0) << name;
  const std::string pixels = probe("clear.mov").at("streams").at(0).at("pix_fmt");
  EXPECT_EQ(pixels.substr(0, 8), "yuva444p");
  EXPECT_EQ(probe("clear.apng").at("streams").at(0).at("pix_fmt"), "rgba");
  ASSERT_EQ(with({"--no-video", "-q", "--out", "frames"}).code, 0);
  EXPECT_EQ(picture("frames/frames/000000.png").at(0, 0)[3], 0);
}

TEST_F(Output, FilesSayWhatTheyAreOf) {
  ASSERT_EQ(render({"-q"}).code, 0);
  const std::string png = read_file(folder_.path() / "out/swing/frames/000002.png");
  for (const char* word :
       {"iTXtSoftware", "iTXtSource", "swing.toml", "iTXttaut:time", "0.1 s", "iTXttaut:method"})
    EXPECT_NE(png.find(word), std::string::npos) << word;
  const nlohmann::json tags = probe("out/swing/swing.mp4").at("format").at("tags");
  EXPECT_EQ(tags.at("title"), "Short swing");
  const std::string comment = tags.at("comment");
  EXPECT_NE(comment.find("scene swing.toml, method "), std::string::npos) << comment;
  const std::string first = read_file(folder_.path() / "out/swing/swing.mp4");
  ASSERT_EQ(render({"-q", "--anew"}).code, 0);
  EXPECT_EQ(read_file(folder_.path() / "out/swing/swing.mp4"), first) << "the same bytes again";
}

TEST_F(Output, WatchingMakesAPosterWheneverTheSceneIsSaved) {
  Child child({TAUT_PROGRAM, "render", "swing.toml", "--watch", "--out", "here"}, folder_.path());
  const fs::path poster = folder_.path() / "here/poster.png";
  ASSERT_TRUE(child.runs_until([&] { return fs::exists(poster); }));
  const std::string first = read_file(poster);
  folder_.write("swing.toml", "duration = -1\n");
  const std::string fault = "duration: found -1";
  EXPECT_NE(child.messages_until(fault).find(fault), std::string::npos);
  std::string other = kShortSwing;
  folder_.write("swing.toml", other.replace(other.find("[1, 0, 0]"), 9, "[0, 1, 1]"));
  EXPECT_TRUE(child.runs_until([&] { return read_file(poster) != first; }));
  kill(child.id(), SIGINT);
  const ProgramResult outcome = child.wait();
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

}  // namespace
}  // namespace taut
