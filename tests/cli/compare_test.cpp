// taut compare: panels, verdicts, the clip, methods that stop, and what is refused.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "render/chart/table.h"
#include "render/picture/picture.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

constexpr const char* kComparedSwing = R"(duration = 0.2
fps = 50
size = [480, 270]
[method]
name = "impulse"
step = 0.001
[connectors.rope]
length = 0.2
mass = 0.05
particles = 6
from = { fixed = [0, 1, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
[stage]
camera = [{ t = 0, position = [0, 0.9, 1], target = [0, 0.9, 0] }]
)";

class Compare : public testing::Test {
 protected:
  ProgramResult compare(std::vector<std::string> more) const {
    more.insert(more.begin(), {"compare", scene_.string(), "--out", out_.string(), "--quiet"});
    return run_taut(more);
  }
  fs::path frame(int number) const {
    return out_ / "frames" / ("00000" + std::to_string(number) + ".png");
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kComparedSwing);
  fs::path out_ = folder_.path() / "compared";
};

TEST_F(Compare, SixMethodsInAClip) {
  const ProgramResult outcome = compare({"--json", "--frames", "0-9,200"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(report.at("methods").size(), 6u);
  EXPECT_GT(report.at("horizon_s"), 0.1);
  for (const auto& method : report.at("methods")) {
    EXPECT_EQ(method.at("frames"), 10);
    EXPECT_GE(method.at("stretch_max"), 0);
    EXPECT_GT(method.at("cpu_us_per_frame"), 0);
  }
  EXPECT_TRUE(fs::exists(out_ / "swing.mp4"));
  EXPECT_EQ(picture::read_png(frame(9)).width, 480);
  const chart::Table table = chart::from_csv(read_file(out_ / "compare.csv"));
  EXPECT_EQ(table.rows.size(), 6u);
  for (const auto& row : table.rows) {
    // Methods that converge to the truth are nearer to it than those that do not.
    const double error = std::stod(row[2]);
    if (row[0] == "direct" || row[0] == "multibody") {
      EXPECT_LT(error, 0.1) << row[0];
    }
    if (row[0] == "impulse") {
      EXPECT_GT(error, 0.1);
    }
    if (row[0] == "dynamic-constraints") {
      EXPECT_EQ(row[1], "0");
    }
  }
}

TEST_F(Compare, CellsDifferWhereMethodsDo) {
  ASSERT_EQ(compare({"--methods", "impulse,direct", "--frames", "0,9", "--no-video"}).code, 0);
  EXPECT_FALSE(fs::exists(frame(1)));
  // At the start both panels show the same; later not. The bands of text and the scale bar, which
  // one panel has, are left out.
  const auto differ = [&](const picture::Picture& picture) {
    int count = 0;
    for (int y = 56; y < 145; ++y)
      for (int x = y < 120 ? 4 : 110; x < 236; ++x)
        count += std::abs(*picture.at(x, y) - *picture.at(x + 240, y)) > 8;
    return count;
  };
  EXPECT_EQ(differ(picture::read_png(frame(0))), 0);
  EXPECT_GT(differ(picture::read_png(frame(9))), 60);
}

TEST_F(Compare, MethodsOverEachOtherAreToldApartByTheirColours) {
  ASSERT_EQ(compare({"--methods", "impulse,xpbd", "--frames", "9", "--no-video", "--over"}).code,
            0);
  EXPECT_FALSE(fs::exists(frame(9))) << "the other layout's";
  const picture::Picture picture = picture::read_png(out_ / "frames_over/000009.png");
  // Of the panel: orange (213, 94, 0) and purple (204, 121, 167) in the light.
  int orange = 0, purple = 0;
  for (int y = 30; y < 250; ++y)
    for (int x = 0; x < 200; ++x) {
      const std::uint8_t* p = picture.at(x, y);
      orange += p[0] > p[2] + 60;
      purple += p[0] > p[1] + 15 && p[2] > p[1] + 15;
    }
  EXPECT_GT(orange, 40);
  EXPECT_GT(purple, 40);
}

TEST_F(Compare, AMethodThatStopsLeavesTheOthers) {
  // Explicit Euler with a step beyond every limit.
  const std::string text = kComparedSwing;
  std::string broken = text;
  broken.replace(broken.find("\"impulse\"\nstep = 0.001"), 22,
                 "\"springs\"\nintegrator = \"explicit-euler\"\nstep = 0.02\nstiffness = 1e6");
  scene_ = folder_.write("broken.toml", broken);
  const ProgramResult outcome =
      compare({"--methods", "springs,direct", "--no-video", "--json", "--frames", "9"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_LT(report.at("methods")[0].at("frames"), 10);
  EXPECT_NE(report.at("methods")[0].at("failure"), "");
  EXPECT_TRUE(report.at("methods")[0].at("from_truth_mm").is_null());
  EXPECT_EQ(report.at("methods")[1].at("frames"), 10);
  EXPECT_EQ(report.at("methods")[1].at("failure"), "");
}

/// The rope drop, short: nothing of it is predictable.
std::string dropped() {
  std::string text = kComparedSwing;
  text.replace(text.find("particles = 6"), 13, "particles = 21");
  text.replace(text.find("[1, 0, 0]"), 9, "[0.0871557, 0.9961947, 0]");
  text.replace(text.find("duration = 0.2"), 14, "duration = 0.4");
  text.replace(text.find("fps = 50"), 8, "fps = 20");
  return text;
}

TEST_F(Compare, LawsJudgeWhereNothingIsPredictable) {
  scene_ = folder_.write("drop.toml", dropped());
  const ProgramResult outcome = compare({"--methods", "impulse,direct", "--no-video", "--json",
                                         "--size", "192x108", "--slower", "3"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_FALSE(report.at("judged_by_truth"));
  const auto& impulse = report.at("methods")[0];
  EXPECT_FALSE(impulse.at("right"));
  const std::string verdict = impulse.at("verdict");
  EXPECT_NE(verdict.find("energy"), std::string::npos) << verdict;
  const auto& direct = report.at("methods")[1];
  EXPECT_TRUE(direct.at("right"));
  EXPECT_EQ(direct.at("verdict"), "keeps energy and length");
  EXPECT_EQ(report.at("result").get<std::string>().find("direct keeps energy and length, for "),
            0u);
  // No method is a yardstick that is wrong itself.
  const chart::Table table = chart::from_csv(read_file(out_ / "compare.csv"));
  for (const std::string& column : table.columns)
    EXPECT_EQ(column.find("from"), std::string::npos) << column;
  EXPECT_EQ(table.rows[1].back(), "keeps energy and length");
  // Slow motion (22), a stop for each (2 x 22), real time (8) and the card (100).
  EXPECT_TRUE(fs::exists(out_ / "frames/000173.png"));
  EXPECT_FALSE(fs::exists(out_ / "frames/000174.png"));
}

TEST_F(Compare, SixTimesSlowerWhereNothingIsPredictable) {
  scene_ = folder_.write("drop.toml", dropped());
  const ProgramResult outcome =
      compare({"--methods", "direct", "--no-video", "--json", "--size", "64x36", "--frames", "0"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(nlohmann::json::parse(outcome.output).at("slower"), 6);
}

TEST_F(Compare, FramesAreThoseOfTheClip) {
  // In real time 10 frames, then five seconds of a card.
  EXPECT_EQ(compare({"--methods", "direct", "--no-video", "--frames", "259"}).code, 0);
  EXPECT_TRUE(fs::exists(out_ / "frames/000259.png"));
  const ProgramResult outcome = compare({"--methods", "direct", "--no-video", "--frames", "260"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.messages.find("beyond the clip's last, 259"), std::string::npos);
}

TEST_F(Compare, TimesOfAnotherRunMakeTheSameBytes) {
  const std::vector<std::string> command{"--methods", "impulse,direct", "--frames",
                                         "5,200",     "--no-video",     "--json"};
  ASSERT_EQ(compare(command).code, 0);
  const std::string times = (folder_.path() / "times.json").string();
  fs::copy(out_ / "compare.json", times);
  std::vector<std::string> again = command;
  again.insert(again.end(), {"--times", times});
  const std::vector<fs::path> files{out_ / "frames/000005.png", out_ / "frames/000200.png",
                                    out_ / "compare.json", out_ / "compare.csv"};
  std::vector<std::string> bytes;
  for (const fs::path& file : files) bytes.push_back(read_file(file));
  ASSERT_EQ(compare(again).code, 0);
  for (std::size_t i = 0; i < files.size(); ++i)
    EXPECT_EQ(read_file(files[i]) == bytes[i], true) << files[i];
}

TEST_F(Compare, TimesThatAreNoneAreRefused) {
  const auto refused = [&](const std::string& text) {
    const std::string file = folder_.write("times.json", text).string();
    const ProgramResult outcome = compare({"--methods", "direct", "--no-video", "--times", file});
    EXPECT_EQ(outcome.code, 2) << text;
    return outcome.messages;
  };
  EXPECT_NE(refused("no json").find("times.json: methods is missing"), std::string::npos);
  EXPECT_NE(refused(R"({"methods": [{"method": "direct"}]})")
                .find("methods[0].cpu_us_per_frame is missing"),
            std::string::npos);
  EXPECT_NE(refused(R"({"methods": [{"method": "xpbd", "cpu_us_per_frame": 3}]})")
                .find("has no method direct"),
            std::string::npos);
  EXPECT_EQ(compare({"--times", (folder_.path() / "none.json").string()}).code, 2);
}

TEST_F(Compare, ARopeThatNothingHoldsKeepsItsMomentum) {
  scene_ = folder_.write("thrown.toml", R"(duration = 0.2
fps = 20
[connectors.rope]
length = 0.5
mass = 0.05
particles = 6
from = { point_mass = 0.1 }
to = { free = true }
start = { points = [[0, 1, 0], [0.3, 1, 0], [0.3, 1.3, 0]] }
)");
  const ProgramResult outcome =
      compare({"--methods", "direct", "--frames", "0", "--no-video", "--size", "64x36", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_TRUE(nlohmann::json::parse(outcome.output).at("methods")[0].at("right"));
}

TEST_F(Compare, RefusesBeforeWorking) {
  EXPECT_EQ(compare({"--methods", "spring"}).code, 2);
  EXPECT_EQ(compare({"--frames", "8-2"}).code, 2);
  EXPECT_EQ(compare({"--frames", "8-99999"}).code, 2);
  EXPECT_EQ(compare({"--size", "63x36"}).code, 2);
  EXPECT_EQ(compare({"--size", "100000x200", "--no-video", "--methods", "direct"}).code, 4);
  out_ = folder_.write("file", "x") / "clip";
  scene_ = folder_.write("swing.toml", kComparedSwing);
  EXPECT_EQ(compare({}).code, 6);
}

}  // namespace
}  // namespace taut
