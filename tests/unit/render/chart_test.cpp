#include "render/chart/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>

#include "render/base/error.h"

namespace taut::chart_test {
namespace {

chart::Chart small_chart() {
  chart::Chart chart;
  chart.title = "Halving the step quarters the error";
  chart.subtitle = "a test";
  chart.width = 640;
  chart.height = 400;
  chart::Panel panel;
  panel.x = {"step (s)", true};
  panel.y = {"error (m)", true};
  chart::Series series{"springs", chart::method_style(4), true, true, false, {}};
  for (int i = 0; i < 6; ++i) {
    const double step = 0.1 / (1 << i);
    series.points.push_back(
        {step, step * step, step * 0.9, step * 1.1, chart::kAuto, chart::kAuto});
  }
  panel.series = {series};
  chart.panels = {panel};
  return chart;
}

unsigned big_endian(const std::string& bytes, std::size_t at) {
  unsigned value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  }
  return value;
}

TEST(Chart, PngHasTheAskedSize) {
  const std::string png = chart::draw_chart(small_chart(), chart::ChartFormat::png);
  ASSERT_EQ(png.substr(0, 4), "\x89PNG");
  EXPECT_EQ(big_endian(png, 16), 640u);
  EXPECT_EQ(big_endian(png, 20), 400u);
}

TEST(Chart, SvgSaysWhatItShows) {
  const std::string svg = chart::draw_chart(small_chart(), chart::ChartFormat::svg);
  for (const char* text : {"Halving the step quarters the error", "step (s)", "error (m)",
                           "springs", "rgb(230, 159,   0)", "10⁻³"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
}

TEST(Chart, LinesOfAnSvgAreCalledByTheirNames) {
  const std::string svg = chart::draw_chart(small_chart(), chart::ChartFormat::svg);
  EXPECT_EQ(svg.find("gnuplot_plot_1a</title>"), std::string::npos);
  EXPECT_EQ(svg.find("<title>Gnuplot"), std::string::npos);
  EXPECT_NE(svg.find("<title>Halving the step quarters the error</title>"), std::string::npos);
  EXPECT_NE(svg.find("<g id=\"gnuplot_plot_2a\" ><title>springs</title>"), std::string::npos);
}

TEST(Chart, IsTheSameEachTime) {
  EXPECT_EQ(chart::draw_chart(small_chart(), chart::ChartFormat::svg),
            chart::draw_chart(small_chart(), chart::ChartFormat::svg));
}

// Text of a chart comes from scene files: it must reach the picture as it is and run nothing.
TEST(Chart, TextIsNeverCode) {
  const std::filesystem::path trap = std::filesystem::temp_directory_path() / "taut_chart_trap";
  std::filesystem::remove(trap);
  chart::Chart chart = small_chart();
  chart.title = "it's'; system('touch " + trap.string() + "'); print '`touch " + trap.string() +
                "` a_b^c {d} \\n @e";
  chart.panels[0].x.label = "x\nset output 'y'";
  const std::string svg = chart::draw_chart(chart, chart::ChartFormat::svg);
  EXPECT_FALSE(std::filesystem::exists(trap));
  EXPECT_NE(svg.find("a_b^c {d}"), std::string::npos);
  EXPECT_NE(svg.find("x set output ’y’"), std::string::npos);
}

TEST(Chart, StylesDifferInColourAndWithoutIt) {
  std::set<std::uint32_t> colors;
  std::set<std::tuple<int, int>> forms;
  for (std::size_t i = 0; i < 8; ++i) {
    colors.insert(chart::method_style(i).color);
    forms.insert({chart::method_style(i).dash, chart::method_style(i).marker});
  }
  colors.insert(chart::truth_style().color);
  forms.insert({chart::truth_style().dash, chart::truth_style().marker});
  EXPECT_EQ(colors.size(), 9u);
  EXPECT_EQ(forms.size(), 9u);
}

TEST(Chart, RangeHoldsEverySpreadAndSkipsWhatALogAxisCannotShow) {
  chart::Panel panel = small_chart().panels[0];
  panel.series[0].points.push_back({0.0, -1.0});
  panel.series[0].points.push_back({chart::kAuto, chart::kAuto});
  const auto [low, high] = chart::x_range(panel);
  EXPECT_GT(low, 0);
  EXPECT_LT(low, 0.9 * 0.1 / 32);
  EXPECT_GT(high, 0.11);
  EXPECT_LT(high, 0.3);
  panel.x.minimum = 0.5;
  EXPECT_EQ(chart::x_range(panel).first, 0.5);
}

TEST(Chart, MapFillsItsPanel) {
  chart::Chart chart = small_chart();
  chart.kinds = {{"failed", "F", 0x3b0f70}, {"accurate", "A", 0xfcfdbf}};
  chart.panels[0].series.clear();
  chart.panels[0].cells = {{1, 10, 1e-3, 1e-2, 0}, {10, 100, 1e-3, 1e-2, 1}};
  EXPECT_EQ(chart::x_range(chart.panels[0]), (std::pair{1.0, 100.0}));
  EXPECT_EQ(chart::y_range(chart.panels[0]), (std::pair{1e-3, 1e-2}));
  const std::string svg = chart::draw_chart(chart, chart::ChartFormat::svg);
  EXPECT_NE(svg.find("accurate"), std::string::npos);
}

TEST(Chart, LegendNamesOnlyWhatIsDrawn) {
  chart::Chart chart = small_chart();
  chart.panels[0].series.push_back({"nothing", chart::method_style(5), true, true, false, {}});
  chart.panels[0].series.push_back(
      {"below zero", chart::method_style(6), true, true, false, {{0.1, -1}}});
  chart.kinds = {{"failed", "F", 0x3b0f70}, {"accurate", "A", 0xfcfdbf}};
  chart.panels[0].cells = {{1e-3, 1e-2, 1e-3, 1e-2, 1}};
  std::vector<std::string> names;
  for (const auto& entry : chart::chart_layout::layout_of(chart).legend)
    names.push_back(entry.name);
  EXPECT_EQ(names, (std::vector<std::string>{"springs", "A  accurate"}));
}

TEST(Chart, ARulesLabelStandsWhereFewerCurvesAre) {
  const chart::Panel panel = small_chart().panels[0];  // its curve rises
  EXPECT_TRUE(chart::chart_layout::is_label_right(panel, {1.1e-5, false, "low"}));
  EXPECT_FALSE(chart::chart_layout::is_label_right(panel, {0.9e-2, false, "high"}));
  EXPECT_FALSE(chart::chart_layout::is_label_right(panel, {1.1e-5, true, "upright"}));
}

TEST(Chart, PanelsLieApartInsideThePicture) {
  chart::Chart chart = small_chart();
  chart.panels.resize(5, chart.panels[0]);
  chart.columns = 3;
  for (std::size_t i = 0; i < chart.panels.size(); ++i) {
    const chart::PlotArea a = chart::plot_area(chart, i);
    EXPECT_GE(a.left, 0);
    EXPECT_LT(a.left, a.right);
    EXPECT_LE(a.right, chart.width);
    EXPECT_LT(a.top, a.bottom);
    EXPECT_LE(a.bottom, chart.height);
    for (std::size_t j = 0; j < i; ++j) {
      const chart::PlotArea b = chart::plot_area(chart, j);
      EXPECT_TRUE(a.left >= b.right || b.left >= a.right || a.top >= b.bottom || b.top >= a.bottom);
    }
  }
}

TEST(Chart, WritesBothFilesAndLeavesNoParts) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "taut_chart_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  chart::write_chart(small_chart(), folder / "a");
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_EQ(names, (std::set<std::string>{"a.png", "a.svg"}));
  EXPECT_THROW(chart::write_chart(small_chart(), folder / "a.png" / "b"), render::CannotWrite);
  std::filesystem::remove_all(folder);
}

TEST(Chart, MissingGnuplotIsSaid) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  try {
    chart::draw_chart(small_chart(), chart::ChartFormat::svg);
    ADD_FAILURE() << "drawn without gnuplot";
  } catch (const render::CannotWrite& error) {
    EXPECT_NE(std::string(error.what()).find("gnuplot-nox"), std::string::npos);
  }
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace taut::chart_test
