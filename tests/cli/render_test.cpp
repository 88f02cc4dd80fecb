// taut render: frames, video, resuming, and what is refused before any work is done.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "render/picture/picture.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const std::string kStickSwing = swing_scene(0.2);

class Render : public testing::Test {
 protected:
  ProgramResult render(std::vector<std::string> more) const {
    more.insert(more.begin(), {"render", scene_.string(), "--out", out_.string(), "--quiet"});
    return run_taut(more);
  }
  fs::path frame(int number) const {
    return out_ / "frames" / ("00000" + std::to_string(number) + ".png");
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kStickSwing);
  fs::path out_ = folder_.path() / "clip";
};

TEST_F(Render, MakesFramesAndVideo) {
  const ProgramResult outcome = render({"--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(report.at("frames"), 10);
  EXPECT_EQ(report.at("frames_drawn"), 10);
  EXPECT_EQ(report.at("method").at("name"), "impulse");
  EXPECT_GT(report.at("seconds_per_frame").at("rendering"), 0);
  EXPECT_TRUE(fs::exists(out_ / "swing.mp4"));
  EXPECT_TRUE(fs::exists(out_ / "clip.json"));
  for (int i = 0; i < 10; ++i) {
    const picture::Picture picture = picture::read_png(frame(i));
    EXPECT_EQ(picture.width, 64);
    EXPECT_EQ(picture.height, 36);
  }
  for (const auto& entry : fs::recursive_directory_iterator(out_))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
}

TEST_F(Render, ClipSaysItsErrorEstimate) {
  ASSERT_EQ(render({"--no-video", "--method", "xpbd", "--step", "0.00005"}).code, 0);
  const auto clip = nlohmann::json::parse(read_file(out_ / "clip.json"));
  EXPECT_GT(clip.at("error_estimate_m").at("largest"), 0);
  EXPECT_GT(clip.at("error_estimate_m").at("final"), 0);
  EXPECT_TRUE(clip.at("predictable_until_s").is_null());
  EXPECT_GT(clip.at("estimate_ms_per_second"), 0);
  const std::string with = read_file(frame(9));
  ASSERT_EQ(
      render({"--no-video", "--method", "xpbd", "--step", "0.00005", "--anew", "--no-estimate"})
          .code,
      0);
  EXPECT_FALSE(
      nlohmann::json::parse(read_file(out_ / "clip.json")).contains("predictable_until_s"));
  EXPECT_EQ(read_file(frame(9)), with);
}

TEST_F(Render, ProfileListsTheStages) {
  const ProgramResult outcome = render({"--profile", "--no-video", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  double wall = 0;
  std::vector<std::string> names, floors;
  for (const auto& stage : report.at("profile")) {
    names.push_back(stage.at("stage"));
    wall += stage.at("wall").get<double>();
    if (stage.contains("floor")) {
      floors.push_back(stage.at("stage"));
      EXPECT_GT(stage.at("floor").get<double>(), 0) << floors.back();
    }
  }
  for (const char* name : {"figures", "read back", "PNG"})
    EXPECT_EQ(std::ranges::count(floors, name), 1) << name;
  for (const char* name : {"pose", "sweep", "figures", "PNG"})
    EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  EXPECT_GT(report.at("seconds_per_frame").at("simulation").get<double>(), 0);
  EXPECT_GE(report.at("mean_exposures").get<double>(), 1);
  EXPECT_GT(wall, 0);
  EXPECT_LT(wall, 2 * report.at("seconds_per_frame").at("rendering").get<double>());
  const ProgramResult table = render({"--profile", "--no-video"});
  EXPECT_NE(table.output.find("one after another"), std::string::npos) << table.output;
}

TEST_F(Render, OnlyTheFramesAskedFor) {
  const ProgramResult outcome = render({"--frames", "7,2-3,2,3,2-3,7-7,7,3,2,7", "--no-video"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_FALSE(fs::exists(out_ / "swing.mp4"));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(fs::exists(frame(i)), i == 2 || i == 3 || i == 7) << i;
}

TEST_F(Render, ResumeKeepsWhatWouldComeOutTheSame) {
  ASSERT_EQ(render({"--frames", "0-4", "--no-video"}).code, 0);
  const auto drawn = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--no-video", "--resume", "--json"});
    const ProgramResult outcome = render(more);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return nlohmann::json::parse(outcome.output).at("frames_drawn").get<int>();
  };
  EXPECT_EQ(drawn({}), 5);
  const std::string whole = read_file(frame(3));
  fs::resize_file(frame(3), whole.size() / 2);
  EXPECT_EQ(drawn({}), 1);
  EXPECT_EQ(read_file(frame(3)), whole);
  EXPECT_EQ(drawn({"--samples", "1"}), 10);
}

TEST_F(Render, FramesAreTheSameOnAnyNumberOfThreads) {
  std::vector<std::string> alone;
  for (const char* threads : {"1", "2", "4"}) {
    ASSERT_EQ(render({"--threads", threads, "--no-video", "--anew"}).code, 0);
    std::vector<std::string> files;
    for (int i = 0; i < 10; ++i) files.push_back(read_file(frame(i)));
    if (alone.empty()) alone = files;
    EXPECT_TRUE(files == alone) << threads << " threads";
  }
}

TEST_F(Render, AListOfFramesMayBeLong) {
  const ProgramResult outcome =
      render({"--frames", "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1", "--no-video", "--json"});
  ASSERT_EQ(outcome.code, 0);
  EXPECT_EQ(nlohmann::json::parse(outcome.output).at("frames"), 2);
}

// The more samples, the nearer to the light of the whole pixel, also beyond those of a driver.
TEST_F(Render, TakesAnyNumberOfSamples) {
  std::vector<picture::Picture> pictures;
  for (const char* samples : {"1", "4", "16", "64"}) {
    ASSERT_EQ(render({"--no-video", "--frames", "3", "--samples", samples}).code, 0);
    pictures.push_back(picture::read_png(frame(3)));
  }
  std::vector<long> apart;  // from the last
  for (const picture::Picture& one : pictures) {
    apart.push_back(0);
    for (std::size_t i = 0; i < one.pixels.size(); ++i) {
      const long difference = long(one.pixels[i]) - pictures.back().pixels[i];
      apart.back() += difference * difference;
    }
  }
  EXPECT_LT(2 * apart[1], apart[0]);
  EXPECT_LT(2 * apart[2], apart[1]);
}

TEST_F(Render, RefusesBeforeWorking) {
  EXPECT_EQ(render({"--size", "63x36"}).code, 2);
  EXPECT_EQ(render({"--size", "0x36"}).code, 2);
  EXPECT_EQ(render({"--size", "64"}).code, 2);
  EXPECT_EQ(render({"--frames", "8-12"}).code, 2);
  EXPECT_EQ(render({"--frames", "3-1"}).code, 2);
  EXPECT_EQ(render({"--frames", "x"}).code, 2);
  EXPECT_EQ(render({"--backend", "vulkan"}).code, 2);
  EXPECT_EQ(render({"--size", "100000x2", "--no-video"}).code, 4);
  EXPECT_EQ(render({"--samples", "65"}).code, 2);
  EXPECT_FALSE(fs::exists(out_)) << "something was begun all the same";
}

TEST_F(Render, Stills) {
  const std::string captions =
      "captions = [{ from = 0, until = 0.1, text = \"swings\" },"
      " { from = 0.1, until = 0.2, text = \"falls\" }]\n";
  scene_ = folder_.write("stills.toml", kStickSwing + captions);
  ASSERT_EQ(render({"--contact-sheet", "--poster", "0.1", "--size", "96x54"}).code, 0);
  EXPECT_EQ(picture::read_png(out_ / "contact_sheet.png").height, 18);
  EXPECT_EQ(picture::read_png(out_ / "poster.png").width, 96);
  EXPECT_FALSE(fs::exists(out_ / "frames"));
}

TEST_F(Render, SceneWithoutAStage) {
  const std::string text = kStickSwing;
  scene_ = folder_.write("bare.toml", text.substr(0, text.find("[stage]")));
  ASSERT_EQ(render({"--poster", "0.1", "--size", "96x54"}).code, 0);
  EXPECT_EQ(picture::read_png(out_ / "poster.png").width, 96);
}

TEST_F(Render, OutputUnderAFile) {
  out_ = folder_.write("file", "x") / "clip";
  const ProgramResult outcome = render({});
  EXPECT_EQ(outcome.code, 6) << outcome.messages;
}

TEST_F(Render, FfmpegMissing) {
  const ProgramResult outcome =
      run_taut({"render", scene_.string(), "--out", out_.string()}, TAUT_SOURCE_DIR,
               [] { setenv("PATH", "/nonexistent", 1); });
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.messages.find("ffmpeg"), std::string::npos) << outcome.messages;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(Render, FfmpegWithoutFfprobe) {
  const fs::path program = folder_.write("bin/ffmpeg", "#!/bin/sh\n");
  fs::permissions(program, fs::perms::owner_all);
  const std::string path = program.parent_path().string();
  const ProgramResult outcome = run_taut({"render", scene_.string(), "--out", out_.string()},
                                         TAUT_SOURCE_DIR, [&] { setenv("PATH", path.c_str(), 1); });
  EXPECT_EQ(outcome.code, 5);
  EXPECT_NE(outcome.messages.find("ffprobe"), std::string::npos) << outcome.messages;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(Render, FfmpegThatFailsOrStopsShort) {
  const auto with_ffmpeg = [&](const std::string& script) {
    const fs::path program = folder_.write("bin/ffmpeg", "#!/bin/sh\n" + script);
    fs::permissions(program, fs::perms::owner_all);
    const std::string path = program.parent_path().string() + ":/usr/bin:/bin";
    return run_taut({"render", scene_.string(), "--out", out_.string(), "--quiet"}, TAUT_SOURCE_DIR,
                    [&] { setenv("PATH", path.c_str(), 1); })
        .code;
  };
  const std::string asked = "case \"$*\" in *-version*) exit 0;; esac\n";
  EXPECT_EQ(with_ffmpeg(asked + "exit 1\n"), 5);
  EXPECT_EQ(with_ffmpeg(asked + "exit 0\n"), 5);
  EXPECT_FALSE(fs::exists(out_ / "swing.mp4"));
  EXPECT_TRUE(fs::exists(frame(9))) << "frames already made stay";
}

TEST_F(Render, BackendsGiveTheSamePixels) {
  ASSERT_EQ(render({"--frames", "5", "--no-video", "--backend", "egl"}).code, 0);
  const picture::Picture egl = picture::read_png(frame(5));
  ASSERT_EQ(render({"--frames", "5", "--no-video", "--backend", "osmesa"}).code, 0);
  EXPECT_EQ(egl.pixels, picture::read_png(frame(5)).pixels);
}

}  // namespace
}  // namespace taut
