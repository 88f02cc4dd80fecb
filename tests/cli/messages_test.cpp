// What the program says: all of it reaches standard output, and no name in it is obeyed.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

class Messages : public testing::Test {
 protected:
  ProgramResult run(const std::vector<std::string>& words,
                    const std::function<void()>& prepare = {}) const {
    return run_taut(words, folder_.path(), prepare);
  }

  Folder folder_;
  fs::path scene_ = folder_.write("swing.toml", kShortSwing);
};

TEST_F(Messages, AFullStandardOutputIsSix) {
  std::vector<std::vector<std::string>> all = {{"--help"},
                                               {"--version"},
                                               {"check", "--schema"},
                                               {"check", "swing.toml"},
                                               {"check", "swing.toml", "--json"},
                                               {"simulate", "swing.toml", "--csv", "-"},
                                               {"simulate", "swing.toml", "--json"},
                                               {"claims", "--help"}};
  for (const char* command : {"render", "simulate", "export", "check", "chart", "plan", "demo"})
    all.push_back({command, "--help"});
  for (const auto& words : all) {
    const ProgramResult outcome =
        run(words, [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); });
    EXPECT_EQ(outcome.code, 6) << words[0] << ' ' << words.back() << outcome.messages;
    EXPECT_NE(outcome.messages.find("standard output: No space left on device"), std::string::npos)
        << words[0] << ' ' << words.back() << outcome.messages;
  }
}

/// No message obeys a name: control characters, ends of lines and bytes that are no text.
TEST_F(Messages, NamesInMessagesAreEscaped) {
  std::string scene = kShortSwing;
  scene.replace(scene.find("title = \"Short swing\""), 21, R"(title = "A\u001b[31m\nBC")");
  folder_.write("s\nw\x1b\xff.toml", scene);
  folder_.write("bad.toml", "[bodies.\"a\\u001b\\nb\\u0000c\"]\nmass = -1\n");
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"check", "s\nw\x1b\xff.toml"},
           {"check", "s\nw\x1b\xff.toml", "--json"},
           {"check", "missing\n\x1b\xff.toml"},
           {"check", "missing\n\x1b\xff.toml", "--json"},
           {"check", "bad.toml"},
           {"check", "bad.toml", "--json"},
           {"check", "swing.toml", "--set", "a\n\x1b=1"},
           {"chec\nk\x1b"},
           {"check", "--sch\x1b\nx"},
           {"simulate", "swing.toml", "--method", "x\x1b\ny"},
           {"simulate", "s\nw\x1b\xff.toml", "--csv", "t\n\x1b.csv"},
           {"simulate", "swing.toml", "--csv", "swing.toml/\n\x1b.csv"},
           {"render", "swing.toml", "-o", "t\n\x1b.abc"}}) {
    const ProgramResult outcome = run(words);
    for (const std::string& text : {outcome.messages, outcome.output}) {
      EXPECT_EQ(text.find_first_of("\x1b\xff"), std::string::npos) << text;
      EXPECT_EQ(text.find('\0'), std::string::npos) << text;
    }
    EXPECT_EQ(outcome.messages.find("internal error"), std::string::npos) << outcome.messages;
    std::istringstream lines(outcome.messages);
    for (std::string line; outcome.code != 0 && std::getline(lines, line);)
      EXPECT_TRUE(line.starts_with("taut: ")) << line;
  }
  EXPECT_NE(run({"check", "s\nw\x1b\xff.toml"}).output.find("A\\x1b[31m\\nBC: "),
            std::string::npos);
  EXPECT_NE(run({"check", "bad.toml"}).messages.find("a\\x1b\\nb\\x00c"), std::string::npos);
}

TEST_F(Messages, CheckNamesTheCharactersThatCaptionsCannotShow) {
  folder_.write("captions.toml", std::string(kShortSwing) + R"(
[[stage.captions]]
from = 0.0
until = 0.1
text = "Gr\u00fc\u00dfe\u200b so\u00adft\n\u041f\u0440"
[[stage.captions]]
from = 0.0
until = 0.1
text = "\u53cc\u7bc0\u68cd\u30cc\u30f3\u30c1\u30e3"
)");
  const nlohmann::json checked =
      nlohmann::json::parse(run({"check", "captions.toml", "--json"}).output);
  const std::string warnings = checked.at("warnings").dump();
  EXPECT_EQ(warnings.find("caption 1"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("caption 2: the font has no glyph for \\\"\u53cc\\\" (U+53CC)"),
            std::string::npos)
      << warnings;
  EXPECT_NE(warnings.find("and 2 more characters"), std::string::npos) << warnings;
}

}  // namespace
}  // namespace taut
