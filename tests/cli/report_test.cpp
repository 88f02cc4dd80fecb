// taut report: one page that needs no other, whose points say the commands that make them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>

#include "render/options/method_options.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSwing = R"(title = "Short </swing>"
duration = 0.2
fps = 20
size = [160, 120]
[method]
name = "springs"
step = 0.0005
stiffness = 4000
[connectors.rope]
length = 0.2
mass = 0.05
particles = 4
from = { fixed = [0, 0.6, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
)";

class Report : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    folder_->write("my scene.toml", kSwing);
    made_ = run_taut({"report", "my scene.toml", "--quick", "--budget", "6", "--methods",
                      "springs,springs:explicit-euler,direct,xpbd", "--json", "-q"},
                     folder_->path());
    page_ = read_file(folder_->path() / "out/my scene/report.html");
  }
  static void TearDownTestSuite() { delete folder_; }

  /// The charts of the page.
  static std::vector<nlohmann::json> charts() {
    std::vector<nlohmann::json> all;
    const std::string mark = "<script type=\"application/json\">";
    for (std::size_t at = page_.find(mark); at != std::string::npos;
         at = page_.find(mark, at + 1)) {
      const std::size_t begin = at + mark.size();
      all.push_back(
          nlohmann::json::parse(page_.substr(begin, page_.find("</script>", begin) - begin)));
    }
    return all;
  }
  /// A command of the page, in a shell that finds taut.
  static ProgramResult paste(const std::string& command) {
    return Child({"sh", "-c", command}, folder_->path(),
                 [] {
                   const std::string path = fs::path(TAUT_PROGRAM).parent_path().string();
                   setenv("PATH", (path + ":" + getenv("PATH")).c_str(), 1);
                 })
        .wait();
  }

  static inline Folder* folder_ = nullptr;
  static inline ProgramResult made_;
  static inline std::string page_;
};

TEST_F(Report, IsOneFileBelowFiveMegabytesAndAsTheSchemaSays) {
  ASSERT_EQ(made_.code, 0) << made_.messages;
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  const nlohmann::json result = nlohmann::json::parse(made_.output);
  EXPECT_EQ(schema.complaint(result, "report"), "");
  EXPECT_EQ(result.at("bytes"), page_.size());
  EXPECT_EQ(result.at("scenes")[0].at("clips"), 3) << "forms of a method have none";
  EXPECT_LT(page_.size(), 5'000'000u);
  // Nothing is fetched: whatever has an address is in the page or leads inside it.
  std::size_t addresses = 0;
  const std::regex address("(src|href|url)\\s*[=(]\\s*[\"']?([^\"')>]{0,12})");
  for (std::sregex_iterator i(page_.begin(), page_.end(), address), end; i != end; ++i) {
    const std::string to = (*i)[2];
    ++addresses;
    EXPECT_TRUE(to.starts_with("data:") || to.starts_with("#")) << (*i)[0];
  }
  EXPECT_GT(addresses, 5u);
  for (const char* call : {"fetch(", "XMLHttpRequest", "import(", "@import", "https://"}) {
    EXPECT_EQ(page_.find(call), std::string::npos) << call;
  }
  EXPECT_NE(page_.find("Short &lt;/swing&gt;"), std::string::npos);
}

TEST_F(Report, BeginsWithAPictureAConclusionDateAndVersion) {
  const std::string start = page_.substr(0, page_.find("<nav>"));
  EXPECT_NE(start.find("data:image/webp;base64,"), std::string::npos);
  EXPECT_NE(start.find(" its error below 0.1% of the length"), std::string::npos);
  EXPECT_TRUE(
      std::regex_search(start, std::regex("20\\d\\d-\\d\\d-\\d\\d, taut \\d+\\.\\d+\\.\\d+")));
}

// The truth cannot tell an error below its own.
TEST_F(Report, PointsLieBetweenTheTruthsErrorAndTheLength) {
  std::smatch known;
  ASSERT_TRUE(
      std::regex_search(page_, known, std::regex("its own error: ([-+.e0-9]+)% of the length")));
  const double self_error = std::stod(known[1]) / 100;
  for (const nlohmann::json& series : charts().at(0).at("panels").at(0).at("series")) {
    for (const nlohmann::json& point : series.at("points")) {
      EXPECT_GE(point.at(1), 0.99 * self_error);  // as it is rounded
      EXPECT_LE(point.at(1), 1);
    }
  }
}

TEST_F(Report, CopiedPointsComeOutTheSame) {
  const nlohmann::json panel = charts().at(0).at("panels").at(0);
  std::size_t compared = 0;
  for (const nlohmann::json& series : panel.at("series")) {
    if (series.at("points").empty() || series.at("faint")) continue;
    for (const nlohmann::json& point : {series.at("points").front(), series.at("points").back()}) {
      const ProgramResult again = paste(point.at(6));
      ASSERT_EQ(again.code, 0) << point.at(6) << again.messages;
      EXPECT_EQ(nlohmann::json::parse(again.output).at("rms_error"), point.at(1)) << point.at(6);
      ++compared;
    }
  }
  EXPECT_GE(compared, 6u);
}

TEST_F(Report, CopiedErrorsOverTimeComeOutTheSame) {
  const nlohmann::json panel = charts().at(1).at("panels").at(0);
  ASSERT_EQ(panel.at("series").size(), 3u);
  for (const nlohmann::json& series : panel.at("series")) {
    const nlohmann::json& points = series.at("points");
    const ProgramResult again = paste(points.at(0).at(6));
    ASSERT_EQ(again.code, 0) << again.messages;
    const nlohmann::json errors = nlohmann::json::parse(again.output).at("errors");
    ASSERT_EQ(errors.size(), points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(errors[k].at("t_s"), points[k][0]);
      EXPECT_EQ(errors[k].at("error"), points[k][1]);
    }
  }
}

TEST_F(Report, CopiedCellsComeOutTheSame) {
  std::size_t compared = 0;
  for (const nlohmann::json& chart : charts()) {
    for (const nlohmann::json& panel : chart.at("panels")) {
      const nlohmann::json& cells = panel.at("cells");
      if (cells.empty()) continue;
      const nlohmann::json& cell = cells.at(cells.size() / 2);
      const std::string kind = chart.at("kinds").at(cell.at(4).get<std::size_t>()).at("name");
      if (kind == "not run") continue;  // which is of this machine
      const std::string command = cell.at(7);
      const ProgramResult again = paste(command + " --json -q");
      ASSERT_EQ(again.code, 0) << command << again.messages;
      EXPECT_EQ(nlohmann::json::parse(again.output).at("scenes")[0].at("methods")[0].at("class"),
                kind)
          << command;
      ++compared;
    }
  }
  EXPECT_GE(compared, 10u);
}

TEST_F(Report, CopiedClipsComeOutTheSame) {
  const std::regex command("<code>(taut render [^<]*)</code>");
  std::size_t compared = 0;
  for (std::sregex_iterator i(page_.begin(), page_.end(), command), end; i != end; ++i) {
    const std::string text = std::regex_replace((*i)[1].str(), std::regex("&#39;|&apos;"), "'");
    const fs::path file = folder_->path() / "out/my scene/report/clips/direct.webm";
    if (text.find("direct") == std::string::npos) continue;
    const std::string before = read_file(file);
    fs::remove_all(folder_->path() / "out/my scene/report/clips");
    EXPECT_EQ(paste(text).code, 0) << text;
    EXPECT_GT(before.size(), 500u);
    EXPECT_TRUE(read_file(file) == before) << text;
    ++compared;
  }
  EXPECT_EQ(compared, 1u);
}

TEST(Quoted, IsOneWordOfAShell) {
  const Folder folder;
  for (const std::string word :
       {"plain", "with space", "it's", "$HOME", "a\"b", "`x`", "", "{ a = 1 }"}) {
    EXPECT_EQ(
        Child({"sh", "-c", "printf %s " + options::quoted(word)}, folder.path()).wait().output,
        word);
  }
}

}  // namespace
}  // namespace taut
