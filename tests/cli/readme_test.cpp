// The tables of results are what the commands beside them say: times differ from machine to
// machine, words must not.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut {
namespace {

using Rows = std::vector<std::vector<std::string>>;

/// The rows below the table header in `text` that starts with `header`.
Rows table_in(const std::string& text, const std::string& header) {
  std::istringstream in(text);
  Rows rows;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(header, 0) == 0) {
      inside = true;
      std::getline(in, line);  // the rule below it
      continue;
    }
    if (!inside) continue;
    if (line.empty() || line[0] != '|') break;
    std::vector<std::string> cells;
    for (std::size_t at = 2; at < line.size();) {
      const std::size_t end = line.find(" |", at);
      cells.push_back(line.substr(at, end - at));
      at = end + 3;
    }
    rows.push_back(std::move(cells));
  }
  return rows;
}

Rows results_table(const std::string& header) {
  return table_in(read_file(TAUT_SOURCE_DIR "/sim/study/README.md"), header);
}

std::string first_word(const std::string& cell) {
  return cell.substr(0, cell.find_first_of(" :"));
}

TEST(LongResults, ClaimsStandAsTheyAreMeasured) {
  const Rows rows = results_table("| the paper says | in | here |");
  const ProgramResult outcome =
      Child({TAUT_PROGRAM, "claims", "scenes/rope_swing.toml", "--json", "-q"}, TAUT_SOURCE_DIR)
          .wait(std::chrono::seconds(600));
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto result = nlohmann::json::parse(outcome.output);
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  EXPECT_EQ(schema.complaint(result, "claims"), "");
  const auto claims = result.at("claims");
  ASSERT_EQ(rows.size(), claims.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at(0), claims[i].at("claim"));
    EXPECT_EQ(rows[i].at(1), claims[i].at("where"));
    EXPECT_EQ(rows[i].at(2), claims[i].at("outcome"))
        << rows[i][0] << ": " << claims[i].at("measured");
  }
}

TEST(LongResults, HardCasesStandAsTheyAreClassified) {
  const Rows rows = results_table("| scene | truth until (s) |");
  const char* methods[] = {"impulse", "dynamic-constraints", "multibody", "springs", "xpbd",
                           "direct"};
  std::vector<std::string> command{TAUT_PROGRAM, "classify"};
  for (const char* scene :
       {"coincident", "falling_chain", "heavy_load", "long_step", "pulled_apart",
        "release_straight_up", "rotating_chain", "taut_snap", "whip"}) {
    command.push_back(std::string("scenes/hard/") + scene + ".toml");
  }
  command.insert(
      command.end(),
      {"--methods", "impulse,dynamic-constraints,multibody,springs,xpbd,direct", "--json", "-q"});
  const ProgramResult outcome = Child(command, TAUT_SOURCE_DIR).wait(std::chrono::seconds(600));
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto scenes = nlohmann::json::parse(outcome.output).at("scenes");
  ASSERT_EQ(rows.size(), scenes.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t m = 0; m < std::size(methods); ++m) {
      const auto& classified = scenes[i].at("methods").at(m);
      ASSERT_EQ(classified.at("method"), methods[m]);
      EXPECT_EQ(first_word(rows[i].at(m + 2)), first_word(classified.at("class")))
          << rows[i][0] << ": " << classified;
    }
  }
}

}  // namespace
}  // namespace taut
