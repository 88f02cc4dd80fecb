// The command line as its users expect it: what was meant, where results go, scenes from anywhere.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "render/options/scene_options.h"
#include "sim/run/method.h"
#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/json_schema.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kCommands = {
    "new",     "render", "simulate", "export",         "check",  "bench", "chart",  "stability",
    "compare", "golden", "classify", "work-precision", "claims", "plan",  "report", "verify"};

class Usage : public testing::Test {
 protected:
  ProgramResult run(const std::vector<std::string>& words,
                    const std::function<void()>& prepare = {}) const {
    return run_taut(words, folder_.path(), prepare);
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kShortSwing);
};

TEST_F(Usage, HelpFitsAHundredColumns) {
  std::vector<std::vector<std::string>> all = {{"--help"}};
  for (const std::string& command : kCommands) all.push_back({command, "--help"});
  for (const auto& words : all) {
    const ProgramResult outcome = run(words);
    ASSERT_EQ(outcome.code, 0) << words.front();
    std::istringstream text(outcome.output);
    for (std::string line; std::getline(text, line);) {
      const auto letters = std::ranges::count_if(line, [](char c) { return (c & 0xc0) != 0x80; });
      EXPECT_LE(letters, 100) << words.front() << ": " << line;
    }
    for (const char* jargon : {"TEXT", "Excludes:", "INT:", "FLOAT"})
      EXPECT_EQ(outcome.output.find(jargon), std::string::npos) << words.front() << ": " << jargon;
  }
}

/// The words of a text with one space between them.
std::string in_one_line(const std::string& text) {
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;) line += word + " ";
  return line;
}

TEST_F(Usage, HelpListsEverySettingOfEveryMethod) {
  const std::string help = in_one_line(run({"simulate", "--help"}).output);
  std::size_t settings = 0;
  for (const MethodInfo& method : all_methods()) {
    const std::size_t at = help.find(std::string(method.name) + ": " + std::string(method.summary));
    ASSERT_NE(at, std::string::npos) << method.name;
    for (const SettingInfo& setting : method.settings) {
      const bool number = std::holds_alternative<double>(setting.fallback);
      EXPECT_EQ(number, !setting.unit.empty()) << method.name << " " << setting.name;
      std::string line = std::string(setting.name) + " = " + setting_text(setting.fallback) + " ";
      if (number && setting.unit != "1") line += std::string(setting.unit) + " ";
      line += std::string(setting.meaning) + " [";
      EXPECT_NE(help.find(line, at), std::string::npos) << method.name << ": " << line;
      ++settings;
    }
  }
  EXPECT_GT(settings, 20U);
}

TEST_F(Usage, SaysItsVersion) {
  const ProgramResult outcome = run({"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.output.rfind("taut ", 0), 0u) << outcome.output;
  EXPECT_NE(outcome.output.find('.'), std::string::npos);
}

TEST_F(Usage, WhatIsMisspeltIsToldApart) {
  for (const auto& [words, says] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"rendr", "swing.toml"}, "rendr is no command, did you mean \"render\"?"},
           {{"simulate", "swing.toml", "--stepp=1"},
            "--stepp is no option of taut simulate, did you mean \"--step\"?"},
           {{"simulate", "swing.toml", "--set", "stepp=1"},
            "--set stepp: direct has no such setting, did you mean \"step\"?"},
           {{"simulate", "swing.toml", "--set", "stiffness=1"},
            "--set stiffness: is a setting of springs; direct has: tolerance, step"},
           {{"--versoin"}, "--versoin is no option, did you mean \"--version\"?"}}) {
    const ProgramResult outcome = run(words);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << outcome.messages;
  }
}

TEST_F(Usage, ErrorsAreJsonWhereResultsAre) {
  folder_.write("bad.toml", std::string(kShortSwing) + "look = \"robe\"\ndiametre = 1\n");
  const ProgramResult outcome = run({"check", "bad.toml", "--json"});
  EXPECT_EQ(outcome.code, 3);
  const nlohmann::json error = nlohmann::json::parse(outcome.output).at("error");
  EXPECT_EQ(error.at("exit_code"), 3);
  EXPECT_EQ(error.at("cause"), "bad scene or asset");
  ASSERT_EQ(error.at("faults").size(), 2u);
  EXPECT_EQ(error.at("faults")[0].at("key"), "connectors.rope.look");
  EXPECT_EQ(error.at("faults")[0].at("line"), 12);
  EXPECT_EQ(error.at("faults")[1].at("line"), 13);
  const nlohmann::json usage = nlohmann::json::parse(run({"simulat", "--json"}).output);
  EXPECT_EQ(usage.at("error").at("exit_code"), 2);
}

TEST_F(Usage, OfManyFaultsTheFirstAreToldAndTheOthersCounted) {
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  const auto many = [&](const std::string& cut, int count) {
    std::string text = kShortSwing;
    for (int i = 0; i < count; ++i) text += cut;
    folder_.write("bad.toml", text);
  };
  const auto first = lines(kShortSwing) + 2;
  many("[[cuts]]\nconector = 'rope'\n", 20'000);
  ProgramResult outcome = run({"check", "bad.toml", "--json"});
  EXPECT_EQ(outcome.code, 3);
  nlohmann::json error = nlohmann::json::parse(outcome.output).at("error");
  EXPECT_EQ(error.at("faults").size(), 100u);
  // Beside the bad key of each, its keys "at" and "t" are missing.
  EXPECT_EQ(error.at("faults")[0].at("line"), first - 1);
  EXPECT_EQ(error.at("more_faults"), 3 * 20'000 - 100);
  EXPECT_FALSE(error.contains("all_faults"));
  EXPECT_EQ(lines(outcome.messages), 101);
  EXPECT_NE(outcome.messages.find("taut: bad.toml: and 59900 more\n"), std::string::npos);
  // Faults that are found one by one.
  many("[[cuts]]\nconnector = 'robe'\nat = 0.1\nt = 0.01\n", 200);
  outcome = run({"check", "bad.toml", "--json"});
  EXPECT_EQ(outcome.code, 3);
  error = nlohmann::json::parse(outcome.output).at("error");
  EXPECT_EQ(error.at("faults").size(), 100u);
  EXPECT_FALSE(error.contains("more_faults"));
  EXPECT_EQ(error.at("all_faults"), false);
  EXPECT_NE(outcome.messages.find("taut: bad.toml: and perhaps more, which have not been looked"),
            std::string::npos);
}

TEST_F(Usage, AnyValueOfASceneCanBeSet) {
  const auto rows = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"simulate", "swing.toml", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  const ProgramResult longer = rows({"--set", "duration=0.4", "--set", "title=Long"});
  EXPECT_EQ(std::ranges::count(longer.output, '\n'), 9) << longer.messages;
  const ProgramResult other = rows({"--set", "connectors.rope.start.direction[1]=1"});
  EXPECT_NE(other.output, rows({}).output);
  const ProgramResult both = rows(
      {"--set", "connectors.rope.particles=3", "--method", "springs", "--set", "stiffness=5000"});
  EXPECT_EQ(both.code, 0) << both.messages;
  EXPECT_EQ(both.output.substr(0, both.output.find('\n')),
            "t,rope.0.x,rope.0.y,rope.0.z,rope.1.x,rope.1.y,rope.1.z,rope.2.x,rope.2.y,rope.2.z");
  const ProgramResult wrong = rows({"--set", "connectors.rope.lenght=1"});
  EXPECT_EQ(wrong.code, 3);
  EXPECT_NE(wrong.messages.find("connectors.rope.lenght as set: is no key of the format, did you "
                                "mean \"length\"?"),
            std::string::npos)
      << wrong.messages;
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"classify", "swing.toml", "--methods", "impulse"},
        {"check", "swing.toml"},
        {"plan", "swing.toml", "--tolerance", "1mm"}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--set", "connectors.rope.mass=-1"});
    EXPECT_EQ(run(all).code, 3) << words.front();
  }
}

TEST_F(Usage, ASceneComesFromStandardInputAndRowsGoToStandardOutput) {
  const auto from_file = [&] {
    const int file = open(scene_.c_str(), O_RDONLY);
    dup2(file, STDIN_FILENO);
  };
  const ProgramResult piped = run({"simulate", "-", "--csv", "-", "-q"}, from_file);
  EXPECT_EQ(piped.code, 0) << piped.messages;
  EXPECT_EQ(piped.output, run({"simulate", "swing.toml", "-q"}).output);
  EXPECT_EQ(run({"classify", "-", "--methods", "impulse"}, from_file).code, 0);
  folder_.write("bad.toml", "duration = -1\n");
  const ProgramResult bad = run({"check", "-"}, [&] {
    dup2(open((folder_.path() / "bad.toml").c_str(), O_RDONLY), STDIN_FILENO);
  });
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.messages.find("standard input:1:12: duration"), std::string::npos) << bad.messages;
}

TEST_F(Usage, SeveralScenesAtOnce) {
  folder_.write("other.toml", kShortSwing);
  folder_.write("bad.toml", "duration = -1\n");
  const ProgramResult both = run({"simulate", "swing.toml", "bad.toml", "other.toml", "--json"});
  EXPECT_EQ(both.code, 3);
  const nlohmann::json list = nlohmann::json::parse(both.output);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].at("scene"), "swing.toml");
  EXPECT_EQ(list[1].at("error").at("exit_code"), 3);
  EXPECT_EQ(list[2].at("scene"), "other.toml") << "a bad scene does not keep others from theirs";
  ASSERT_EQ(run({"simulate", "swing.toml", "other.toml", "--csv", "rows", "-q"}).code, 0);
  EXPECT_TRUE(fs::exists(folder_.path() / "rows/swing.csv"));
  EXPECT_TRUE(fs::exists(folder_.path() / "rows/other.csv"));
  EXPECT_EQ(run({"simulate", "swing.toml", "other.toml", "--csv", "rows.csv"}).code, 2);
}

TEST(ResultsFolder, IsEachScenesOwn) {
  using options::results_folder;
  EXPECT_EQ(options::results_folder("scenes/rope.toml", "", false), "out/rope");
  EXPECT_EQ(options::results_folder("./scenes/sub/rope.toml", "", false), "out/sub/rope");
  EXPECT_EQ(options::results_folder("other/rope.toml", "", false), "out/other/rope");
  EXPECT_EQ(options::results_folder("/far/away/rope.toml", "", false), "out/far/away/rope");
  EXPECT_EQ(options::results_folder("scenes/rope.toml", "here", false), "here");
  EXPECT_EQ(options::results_folder("scenes/sub/rope.toml", "here", true), "here/sub/rope");
}

TEST_F(Usage, WorkPrecisionAndPlansAreJson) {
  const ProgramResult work_precision =
      run({"work-precision", "swing.toml", "--methods", "impulse,direct", "--errors", "0.1,0.00001",
           "--budget", "2", "--quick", "--json", "-q"});
  ASSERT_EQ(work_precision.code, 0) << work_precision.messages;
  const nlohmann::json scene = nlohmann::json::parse(work_precision.output).at("scenes").at(0);
  EXPECT_GT(scene.at("horizon_s"), 0);
  const nlohmann::json direct = scene.at("methods").at(1).at("work_precision");
  EXPECT_GT(direct.at(1).at("cpu_ms_per_simulated_s"), 0);
  EXPECT_LE(direct.at(1).at("rms_error_m"), 1e-5);
  EXPECT_TRUE(
      scene.at("methods").at(0).at("work_precision").at(1).at("cpu_ms_per_simulated_s").is_null());

  const ProgramResult plans =
      run_taut({"check", "--plans", "scenes/rope_swing.toml", "scenes/hard/whip.toml", "--json"});
  ASSERT_EQ(plans.code, 0) << plans.messages;
  const nlohmann::json list = nlohmann::json::parse(plans.output).at("scenes");
  EXPECT_EQ(list.at(0).at("plan").at("error_unit"), "px");
  EXPECT_GT(list.at(0).at("plan").at("error"), 0);
}

TEST_F(Usage, EveryResultIsAsTheSchemaSays) {
  const JsonSchema schema(
      nlohmann::json::parse(read_file(TAUT_SOURCE_DIR "/render/cli/results.schema.json")));
  const auto check = [&](const std::string& definition, std::vector<std::string> words) {
    words.insert(words.end(), {"--json", "-q"});
    const ProgramResult outcome = run(words);
    EXPECT_EQ(schema.complaint(nlohmann::json::parse(outcome.output, nullptr, false), definition),
              "")
        << outcome.messages;
  };
  check("error", {"simulate", "nowhere.toml"});
  check("error", {"check", "swing.toml", "--set", "fps=-1"});
  check("check", {"check", TAUT_SOURCE_DIR "/scenes/hose.toml"});
  check("check", {"check", TAUT_SOURCE_DIR "/scenes/materials/bungee.toml"});
  check("plans", {"check", "--plans", TAUT_SOURCE_DIR "/scenes/rope_swing.toml", "swing.toml"});
  check("simulate", {"simulate", "swing.toml"});
  check("export", {"export", "swing.toml", "--to", "glb"});
  check("export", {"export", "swing.toml", "--to", "csv"});
  check("render", {"render", "swing.toml", "--size", "64x36"});
  check("score", {"simulate", "swing.toml", "--score", "1e-4"});
  check("compare", {"compare", "swing.toml", "--size", "480x270", "--no-video", "--frames", "0"});
  check("classify", {"classify", "swing.toml"});
  check("verify",
        {"verify", TAUT_SOURCE_DIR "/tests/answers/pendulum", "--methods", "direct,impulse"});
  check("work-precision", {"work-precision", "swing.toml", "--quick", "--budget", "1"});
  check("bench", {"bench", "swing.toml", "--quick", "--budget", "1", "--particles", "4"});
  const std::string motions = TAUT_SOURCE_DIR "/tests/golden/motions";
  check("golden_check", {"golden", "check", motions, "--only", "bench_stick"});
  check("chart", {"chart", "swing.toml", "--quick", "--budget", "1"});
  check("stability", {"stability", "swing.toml", "--quick", "--budget", "1"});
}

TEST_F(Usage, BenchComparesWithWhatThereIs) {
  const ProgramResult outcome = run({"bench", "swing.toml", "--quick", "--budget", "1", "--methods",
                                     "direct,impulse", "--particles", "4", "-q"});
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

TEST_F(Usage, WithoutGnuplotAStudyDoesNotBegin) {
  for (const char* command : {"chart", "stability", "bench"}) {
    const ProgramResult outcome =
        run({command, "swing.toml"}, [] { setenv("PATH", "/nowhere", 1); });
    EXPECT_EQ(outcome.code, 6) << command;
    EXPECT_NE(outcome.messages.find("gnuplot"), std::string::npos) << outcome.messages;
    EXPECT_FALSE(fs::exists(folder_.path() / "out")) << command;
  }
}

TEST_F(Usage, TablesFitTheTerminal) {
  const auto widest = [&](const char* columns) {
    const ProgramResult outcome =
        run({"classify", "swing.toml", "--methods", "impulse,springs,xpbd,direct", "-q"},
            [&] { setenv("COLUMNS", columns, 1); });
    EXPECT_NE(outcome.output.find("direct"), std::string::npos);
    std::size_t most = 0;
    std::istringstream text(outcome.output);
    for (std::string line; std::getline(text, line);) most = std::max(most, line.size());
    return most;
  };
  EXPECT_GT(widest("300"), 60u);
  EXPECT_LE(widest("60"), 60u);
}

TEST_F(Usage, ColorsWhereTheyAreWanted) {
  const std::vector<std::string> words = {"classify", "swing.toml", "--methods", "impulse", "-q"};
  EXPECT_EQ(run(words).output.find('\033'), std::string::npos) << "a pipe";
  const auto force = [] { setenv("CLICOLOR_FORCE", "1", 1); };
  EXPECT_NE(run(words, force).output.find("\033[1m"), std::string::npos);
  const auto both = [&] {
    force();
    setenv("NO_COLOR", "1", 1);
  };
  EXPECT_EQ(run(words, both).output.find('\033'), std::string::npos);
}

TEST_F(Usage, CheckTellsAllFaultsAndWhatIsHardlyMeant) {
  folder_.write("bad.toml", R"(duration = 1
[bodies.ball]
mass = -1
shape = { sphere = { diameter = 0.1 } }
hangs = [0, -1, 0]
[connectors.rope]
length = 1
mass = 0.1
particles = 5
from = { fixed = [0, 1, 0] }
to = { body = "ball" }
[connectors.other]
length = 1
mass = 0.1
particles = 5
from = { path = "nowhere" }
to = { free = true }
)");
  const ProgramResult bad = run({"check", "bad.toml"});
  EXPECT_EQ(bad.code, 3);
  EXPECT_NE(bad.messages.find("bodies.ball.mass"), std::string::npos) << bad.messages;
  EXPECT_NE(bad.messages.find("connectors.other.from.path"), std::string::npos) << bad.messages;
  EXPECT_EQ(std::ranges::count(bad.messages, '\n'), 2) << "and nothing that follows from these\n"
                                                       << bad.messages;
  folder_.write("still.toml", R"(duration = 1
[paths.hand]
keys = [{ t = 0, position = [0, 0, 0] }, { t = 1, position = [1, 0, 0] }]
[bodies.stick]
mass = 1
shape = { sphere = { diameter = 0.1 } }
driven_by = { path = "hand" }
[stage]
camera = [{ t = 0, position = [0, 0, 1], target = [0, 0, 0] }]
)");
  const nlohmann::json still = nlohmann::json::parse(run({"check", "still.toml", "--json"}).output);
  ASSERT_EQ(still.at("warnings").size(), 2u) << still;
  EXPECT_NE(still.at("warnings")[0].get<std::string>().find("nothing is simulated"),
            std::string::npos);
  EXPECT_NE(
      still.at("warnings")[1].get<std::string>().find("body stick is out of the camera's picture"),
      std::string::npos);
}

TEST_F(Usage, CheckWarnsOfAHandBeyondTheArm) {
  const auto warnings = [](const std::string& x) {
    const ProgramResult outcome =
        run_taut({"check", "scenes/nunchaku_paper.toml", "--json", "--set",
                  "paths.right_hand={keys=[{t=0,position=[-0.27,1.0,0.36]},{t=2,position=[" + x +
                      ",1.0,0.36]}]}"});
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return nlohmann::json::parse(outcome.output).at("warnings").dump();
  };
  EXPECT_NE(warnings("2.2").find("out of the arm's reach"), std::string::npos);
  EXPECT_EQ(warnings("-0.2").find("out of the arm's reach"), std::string::npos);
}

TEST(Schema, KnowsWhatCheckKnows) {
  const nlohmann::json schema = nlohmann::json::parse(run_taut({"check", "--schema"}).output);
  EXPECT_FALSE(schema.contains("required")) << "the file that a scene extends may have it";
  EXPECT_NE(schema.at("allOf").dump().find(R"({"required":["extends"]})"), std::string::npos);
  const nlohmann::json& end = schema.at("properties").at("connectors").at("additionalProperties");
  EXPECT_EQ(end.at("properties").at("to").at("properties").at("free").at("const"), true);
}

}  // namespace
}  // namespace taut
