// Pages of one file: what they hold, and that no text of theirs ends a script.
#include "render/chart/html_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace taut::html_page_test {
namespace {

using nlohmann::json;

json data_of(const std::string& chart) {
  const std::string mark = "<script type=\"application/json\">";
  const std::size_t begin = chart.find(mark) + mark.size(), end = chart.find("</script>");
  EXPECT_EQ(chart.find("</script>", end + 1), std::string::npos);
  return json::parse(chart.substr(begin, end - begin));
}

chart::Chart chart_of(const chart::Panel& panel) {
  chart::Chart chart;
  chart.title = "a < b </script>";
  chart.panels = {panel};
  return chart;
}

TEST(HtmlChart, HasWhatTheChartHas) {
  chart::Panel panel;
  panel.x = {"time (s)", true, 0.5};
  panel.series.push_back({"one", {0x0072b2, 1, 2}, true, true, false, {{1, 2}}});
  panel.series.back().points.push_back({3, NAN, 2.5, 3.5});
  panel.series.back().points.back().command = "taut </script>";
  panel.series.push_back({"", {0x0072b2, 1, 2}, false, true, true, {{5, 6}}});
  panel.rules.push_back({1e3, true, "real time"});
  const std::string text = chart::html_chart(chart_of(panel));
  EXPECT_NE(text.find("<h3>a &lt; b &lt;/script&gt;</h3>"), std::string::npos);
  const json data = data_of(text);
  EXPECT_EQ(data.at("title"), "a < b </script>");
  const json& shown = data.at("panels").at(0);
  EXPECT_EQ(shown.at("x"), json({{"label", "time (s)"},
                                 {"log", true},
                                 {"minimum", 0.5},
                                 {"maximum", nullptr},
                                 {"tics", json::array()}}));
  const json& series = shown.at("series");
  EXPECT_EQ(series.at(0).at("color"), "#0072b2");
  EXPECT_EQ(series.at(0).at("points"), json::parse(R"([[1, 2, null, null, null, null, ""],
                            [3, null, 2.5, 3.5, null, null, "taut </script>"]])"));
  EXPECT_EQ(series.at(1).at("name"), "one") << "it hides with the series that looks like it";
  EXPECT_EQ(shown.at("rules").at(0).at("label"), "real time");
}

TEST(HtmlChart, CellsSayWhatTheyStandFor) {
  chart::Panel panel;
  panel.cells.push_back({1, 3, 10, 30, 1, 2, 20, "taut classify"});
  chart::Chart chart = chart_of(panel);
  chart.kinds = {{"bad", "B", 0x3b0f70}, {"good", "G", 0xfcfdbf}};
  const json data = data_of(chart::html_chart(chart));
  EXPECT_EQ(data.at("panels").at(0).at("cells").at(0),
            json::parse(R"([1, 3, 10, 30, 1, 2, 20, "taut classify"])"));
  EXPECT_EQ(data.at("kinds").at(1).at("letter"), "G");
}

TEST(HtmlPage, NeedsNoOtherFile) {
  const std::string page = chart::html_page("a < b", chart::html_command("taut render 'a & b'"));
  EXPECT_NE(page.find("<title>a &lt; b</title>"), std::string::npos);
  EXPECT_NE(page.find("<code>taut render 'a &amp; b'</code>"), std::string::npos);
  for (const char* address : {"src=", "https:", "url(h", "@import"}) {
    EXPECT_EQ(page.find(address), std::string::npos) << address;
  }
}

}  // namespace
}  // namespace taut::html_page_test
