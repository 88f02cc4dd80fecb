// Commands in parts: killed, run again and merged, they make the bytes of one run.
#include <gtest/gtest.h>

#include <csignal>
#include <map>
#include <nlohmann/json.hpp>

#include "render/chart/table.h"
#include "render/program/part.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class RenderParts : public testing::Test {
 protected:
  ProgramResult run(const Words& words) const { return run_taut(words, folder_.path()); }
  void must(const Words& words) const {
    const ProgramResult outcome = run(words + Words{"-q"});
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
  }
  /// Kills a part once what it writes is so long.
  void kill_part(const Words& words, const fs::path& written, std::size_t size) const {
    const ProgramResult outcome =
        stopped_once_written(words + Words{"-q"}, folder_.path(), written, size, SIGKILL);
    EXPECT_EQ(outcome.code, 128 + SIGKILL) << outcome.messages;
  }
  /// All files of a folder but those that hold measured times.
  std::map<std::string, std::string> files(const fs::path& folder) const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path() / folder)) {
      const std::string name = fs::relative(entry.path(), folder_.path() / folder).string();
      const bool kept = name.starts_with("parts") || name == "clip.json" ||
                        name.ends_with("journal") || name.ends_with("lock");
      if (entry.is_regular_file() && !kept) all[name] = read_file(entry.path());
    }
    return all;
  }
  void expect_same(const fs::path& one, const fs::path& other) const {
    const auto a = files(one), b = files(other);
    EXPECT_GT(a.size(), 1u);
    for (const auto& [name, bytes] : a) {
      EXPECT_TRUE(b.contains(name) && b.at(name) == bytes) << name << " differs";
    }
    EXPECT_EQ(a.size(), b.size());
  }

  Folder folder_;
};

TEST(Part, EveryPieceIsOfOnePartAndPartsAreEven) {
  for (const program::Share share : {program::Share::neighbours, program::Share::in_turn}) {
    for (const std::size_t total : {0u, 1u, 7u, 100u, 101u}) {
      for (const std::size_t count : {1u, 2u, 7u, 100u, 150u}) {
        std::vector<int> owners(total);
        for (std::size_t k = 1; k <= count; ++k) {
          const auto pieces = program::pieces_of({k, count, false}, total, share);
          EXPECT_GE(pieces.size(), total / count);
          EXPECT_LE(pieces.size(), (total + count - 1) / count);
          for (std::size_t i = 0; i < pieces.size(); ++i) {
            ++owners.at(pieces[i]);
            if (i == 0) continue;
            EXPECT_EQ(pieces[i] - pieces[i - 1], share == program::Share::in_turn ? count : 1);
          }
        }
        for (const int owner : owners) EXPECT_EQ(owner, 1);
      }
    }
  }
}

TEST_F(RenderParts, OfAClipMakeTheBytesOfOneRun) {
  folder_.write("swing.toml", swing_scene(0.4));
  const Words render{"render", "swing.toml"}, parts = render + Words{"--out", "parts"};
  must(render + Words{"--out", "whole"});
  const fs::path second = folder_.path() / "parts/parts/frames.2-of-3";
  kill_part(parts + Words{"--part", "2/3"}, second / "journal", 60);
  for (const char* part : {"1/3", "3/3"}) must(parts + Words{"--part", part});

  const ProgramResult early = run(parts + Words{"--merge"});
  EXPECT_EQ(early.code, 2);
  EXPECT_NE(early.messages.find("lacks 7 of 20 frames"), std::string::npos) << early.messages;
  EXPECT_NE(early.messages.find("part 2 of 3"), std::string::npos) << early.messages;

  const ProgramResult again = run(parts + Words{"--part", "2/3"});
  EXPECT_EQ(again.code, 0) << again.messages;
  EXPECT_NE(again.messages.find("of 7 frames were there already"), std::string::npos)
      << again.messages;
  const ProgramResult merged = run(parts + Words{"--merge", "--json", "--backend", "auto"});
  ASSERT_EQ(merged.code, 0) << merged.messages;
  EXPECT_EQ(nlohmann::json::parse(merged.output).at("frames"), 20);
  EXPECT_EQ(files("whole").size(), 21u) << "20 frames and a video";
  expect_same("whole", "parts");

  // A run takes up what the merge put there.
  const ProgramResult whole = run(parts + Words{"--json"});
  EXPECT_EQ(nlohmann::json::parse(whole.output).at("frames_drawn"), 0);
}

TEST_F(RenderParts, OfAnotherClipAreNotMerged) {
  folder_.write("swing.toml", swing_scene(0.1));
  const Words render{"render", "swing.toml", "--no-video"};
  const ProgramResult none = run(render + Words{"--merge"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.messages.find("no part has begun"), std::string::npos) << none.messages;
  for (const char* part : {"1/9", "9/9"}) must(render + Words{"--part", part});  // 5 frames
  for (const char* part : {"1/2", "2/2"}) must(render + Words{"--part", part});
  must(render + Words{"--merge"});
  const std::string before = read_file(folder_.path() / "out/swing/frames/000003.png");
  folder_.write("swing.toml", swing_scene(0.1) + "background = [0, 1, 0]\n");
  EXPECT_EQ(run(render + Words{"--merge"}).code, 2);
  EXPECT_EQ(read_file(folder_.path() / "out/swing/frames/000003.png"), before);
  for (const Words& wrong : std::vector<Words>{{"--part", "0/2"},
                                               {"--part", "3/2"},
                                               {"--part", "1"},
                                               {"--part", "1/2", "--merge"},
                                               {"--part", "1/2", "--poster", "0"}}) {
    EXPECT_EQ(run(render + wrong).code, 2);
  }
}

TEST_F(RenderParts, WhoseRecordIsBrokenAreNotDone) {
  folder_.write("swing.toml", swing_scene(0.08));
  for (const char* part : {"1/2", "2/2"}) must({"render", "swing.toml", "--part", part});
  const std::string record = "out/swing/parts/frames.1-of-2/clip.json";
  for (const char* broken : {"{\"renderer\": 5}", "{\"frames_drawn\": \"x\"}", "[", ""}) {
    folder_.write(record, broken);
    const ProgramResult merged = run({"render", "swing.toml", "--merge", "-q"});
    EXPECT_EQ(merged.code, 2) << broken << ": " << merged.messages;
    EXPECT_NE(merged.messages.find("part 1 of 2"), std::string::npos) << merged.messages;
  }
}

TEST_F(RenderParts, OfStabilityMapsMakeTheBytesOfOneRun) {
  folder_.write("swing.toml", kShortSwing);
  // No cell comes near its cap: which do is a matter of time.
  const Words maps{"stability",       "swing.toml", "--quick", "--methods",
                   "springs,impulse", "--budget",   "3600"};
  const Words parts = maps + Words{"--out", "parts"};
  must(maps + Words{"--out", "whole"});
  kill_part(parts + Words{"--part", "1/3"}, folder_.path() / "parts/parts/stability.1-of-3", 500);
  for (const char* part : {"2/3", "1/3", "3/3"}) must(parts + Words{"--part", part});
  must(parts + Words{"--merge"});
  expect_same("whole", "parts");
  EXPECT_TRUE(files("whole").contains("stability.csv"));
}

/// A table's cells but those of columns that hold times or follow from them.
std::vector<Words> untimed(const fs::path& file) {
  chart::Table table = chart::from_csv(read_file(file));
  std::vector<Words> rows{table.columns};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  for (Words& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string& name = table.columns[c];
      if (name.find("CPU") != std::string::npos || name.starts_with("spread") ||
          name == "timings" || name == "on the front" || name.starts_with("ms/s") ||
          name.find("ms per") != std::string::npos)
        row[c] = "";
    }
  }
  return rows;
}

TEST_F(RenderParts, OfAChartMakeTheErrorsOfOneRun) {
  folder_.write("swing.toml", kShortSwing);
  const Words chart{"chart",    "swing.toml", "--methods", "impulse,springs,direct",
                    "--budget", "3600",       "--quick"};
  must(chart + Words{"--out", "whole"});
  const Words parts = chart + Words{"--out", "parts"};
  kill_part(parts + Words{"--part", "2/2"}, folder_.path() / "parts/parts/chart.2-of-2", 200);
  for (const char* part : {"1/2", "2/2"}) must(parts + Words{"--part", part});
  must(parts + Words{"--merge"});
  EXPECT_EQ(untimed(folder_.path() / "whole/chart.csv"),
            untimed(folder_.path() / "parts/chart.csv"));
  EXPECT_GT(untimed(folder_.path() / "whole/chart.csv").size(), 10u);
  const auto first = files("parts");
  must(parts + Words{"--merge"});
  EXPECT_TRUE(files("parts") == first) << "merging is a function of the parts alone";
}

TEST_F(RenderParts, OfWorkPrecisionMergeToOneTable) {
  folder_.write("a.toml", kShortSwing);
  folder_.write("b.toml", kShortSwing);
  const Words command{"work-precision", "a.toml",   "b.toml",      "--methods",
                      "impulse,direct", "--errors", "0.1,0.00001", "--budget",
                      "3600",           "--quick",  "--out",       "out"};
  for (const char* part : {"1/3", "2/3", "3/3"}) must(command + Words{"--part", part});
  const ProgramResult merged = run(command + Words{"--merge", "--json", "-q"});
  ASSERT_EQ(merged.code, 0) << merged.messages;
  const auto scenes = nlohmann::json::parse(merged.output).at("scenes");
  ASSERT_EQ(scenes.size(), 2u);
  // The two scenes are one, but for the name: so are their errors.
  for (const char* key : {"horizon_s", "title"}) EXPECT_EQ(scenes[0].at(key), scenes[1].at(key));
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_EQ(scenes[0].at("methods")[m].at("least_rms_error_m"),
              scenes[1].at("methods")[m].at("least_rms_error_m"));
  }
  EXPECT_EQ(run(command + Words{"--merge", "--json", "-q"}).output, merged.output);
}

TEST_F(RenderParts, SayWhatTheyDidAsTheSchemaHasIt) {
  folder_.write("swing.toml", swing_scene(0.1));
  const ProgramResult part = run({"render", "swing.toml", "--part", "1/2", "--json", "-q"});
  ASSERT_EQ(part.code, 0) << part.messages;
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  EXPECT_EQ(schema.complaint(nlohmann::json::parse(part.output), "part"), "");
  EXPECT_EQ(nlohmann::json::parse(part.output).at("pieces"), 2);
}

using LongRenderParts = RenderParts;

/// `make` with the installed rules, killed with all its parts in the middle, and again. A part that
/// is to be killed does not end by itself, so that it makes no difference how fast the machine is.
TEST_F(LongRenderParts, OfMakeGoOnAfterAKill) {
  if (run_taut({"--version"}).code != 0 || Child({"make", "--version"}, "/").wait().code != 0) {
    GTEST_SKIP() << "make is not installed";
  }
  folder_.write("swing.toml", swing_scene(0.4));
  must({"render", "swing.toml", "--out", "whole"});
  folder_.write("taut.sh", "\"" TAUT_PROGRAM
                           "\" \"$@\" || exit\n"
                           "case \" $* \" in *\" --part $(cat endless) \"*) sleep 1000;; esac\n");
  const Words make{"make",
                   "-f",
                   TAUT_SOURCE_DIR "/render/cluster/parts.mk",
                   "-j",
                   "2",
                   "N=4",
                   "TAUT=sh taut.sh",
                   "COMMAND=render swing.toml --out parts"};
  const auto own_group = [] { setpgid(0, 0); };
  for (const std::string part : {"1", "3"}) {
    folder_.write("endless", part + "/4");
    Child child(make, folder_.path(), own_group);
    const fs::path journal = folder_.path() / "parts/parts" / ("frames." + part + "-of-4/journal");
    std::error_code none;
    EXPECT_TRUE(child.runs_until(
        [&] { return fs::exists(journal, none) && fs::file_size(journal, none) > 0; }));
    kill(-child.id(), SIGKILL);
    EXPECT_EQ(child.wait().code, 128 + SIGKILL);
  }
  folder_.write("endless", "none");
  EXPECT_FALSE(fs::exists(folder_.path() / "parts/swing.mp4"));
  const ProgramResult last = Child(make, folder_.path()).wait();
  ASSERT_EQ(last.code, 0) << last.messages;
  const auto whole = files("whole"), parts = files("parts");
  ASSERT_EQ(whole.size(), 21u);
  for (const auto& [name, bytes] : whole) EXPECT_TRUE(parts.at(name) == bytes) << name;
}

}  // namespace
}  // namespace taut
