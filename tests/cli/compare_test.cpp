// taut compare: cells, tables, methods that stop, and what is refused.
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
  const ProgramResult outcome = compare({"--json"});
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
  // At the start both cells show the same; later not. The label's strip and the scale bar, which
  // one cell has, are left out.
  const auto differ = [&](const picture::Picture& picture) {
    int count = 0;
    for (int y = 40; y < 150; ++y)
      for (int x = y < 140 ? 4 : 110; x < 236; ++x)
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
  // Of the panel below the legend: orange (213, 94, 0) and purple (204, 121, 167) in the light.
  int orange = 0, purple = 0;
  for (int y = 80; y < 250; ++y)
    for (int x = 0; x < 220; ++x) {
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
  const ProgramResult outcome = compare({"--methods", "springs,direct", "--no-video", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(outcome.output);
  EXPECT_LT(report.at("methods")[0].at("frames"), 10);
  EXPECT_NE(report.at("methods")[0].at("failure"), "");
  EXPECT_TRUE(report.at("methods")[0].at("from_truth_mm").is_null());
  EXPECT_EQ(report.at("methods")[1].at("frames"), 10);
  EXPECT_EQ(report.at("methods")[1].at("failure"), "");
}

TEST_F(Compare, RefusesBeforeWorking) {
  EXPECT_EQ(compare({"--methods", "spring"}).code, 2);
  EXPECT_EQ(compare({"--frames", "8-12"}).code, 2);
  EXPECT_EQ(compare({"--size", "63x36"}).code, 2);
  EXPECT_EQ(compare({"--size", "100000x200", "--no-video", "--methods", "direct"}).code, 4);
  out_ = folder_.write("file", "x") / "clip";
  scene_ = folder_.write("swing.toml", kComparedSwing);
  EXPECT_EQ(compare({}).code, 6);
}

}  // namespace
}  // namespace taut
