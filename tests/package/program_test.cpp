// The program as it is once it is installed: its files, manual pages and completion.
#include <sstream>

#include "tests/package/prefix.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

std::string program() {
  return (prefix() / "bin/taut").string();
}

/// The long options that the help of a command lists.
std::vector<std::string> options_in_help(const std::vector<std::string>& command) {
  std::vector<std::string> words = command;
  words.push_back("--help");
  std::istringstream text(must_run(words, prefix()).output);
  std::vector<std::string> options;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (!line.empty() && line[0] != ' ') inside = line.starts_with("Options");
    const std::size_t at = line.find("--");
    if (!inside || at == std::string::npos || at > 6) continue;
    options.push_back(line.substr(at, line.find_first_of(" ,", at) - at));
  }
  EXPECT_FALSE(options.empty()) << command.back();
  return options;
}

TEST(InstalledProgram, FindsItsScenesAndModels) {
  Folder folder;
  must_run({program(), "check", (prefix() / "share/taut/scenes/nunchaku.toml").string()},
           folder.path());
  folder.write("own.toml",
               "duration = 1.0\n[bodies.stick]\nmass = 0.1\nposition = [0, 1, 0]\n"
               "shape = { sphere = { diameter = 0.1 } }\nmesh = \"assets/stick.glb\"\n[stage]\n");
  must_run({program(), "check", "own.toml"}, folder.path());
  must_run({program(), "new", "swing", "--like", "crane"}, folder.path());
  must_run({program(), "check", "swing.toml"}, folder.path());
}

TEST(InstalledProgram, ManualPagesHaveAllThatHelpHas) {
  const fs::path pages = prefix() / "share/man/man1";
  for (const char* name : {"render", "simulate", "check", "demo"}) {
    const fs::path page = pages / (std::string("taut-") + name + ".1.gz");
    const std::string text = must_run({"gzip", "-dc", page.string()}, prefix()).output;
    for (std::string option : options_in_help({program(), name})) {
      for (std::size_t at = 0; (at = option.find('-', at)) != std::string::npos; at += 2) {
        option.insert(at, "\\");
      }
      EXPECT_NE(text.find("\\fB" + option + "\\fR"), std::string::npos) << name << " " << option;
    }
  }
}

/// The completions of bash where the last of the words is being typed.
std::string completed(const std::string& words) {
  return must_run({"bash", "-c",
                   "source share/bash-completion/completions/taut; COMP_WORDS=(" + words +
                       "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _taut; echo \"${COMPREPLY[*]}\""},
                  prefix())
      .output;
}

TEST(InstalledProgram, BashCompletesCommandsOptionsAndChoices) {
  EXPECT_EQ(completed("taut rend"), "render\n");
  EXPECT_EQ(completed("taut sim"), "simulate\n");
  EXPECT_EQ(completed("taut render scene.toml --backend e"), "egl\n");
  EXPECT_EQ(completed("taut simulate --method imp"), "impulse\n");
  EXPECT_EQ(completed("taut simulate --set stiff"), "stiffness=\n");
  const std::string offered = " " + completed("taut render -");
  for (const std::string& option : options_in_help({program(), "render"})) {
    EXPECT_NE(offered.find(" " + option), std::string::npos) << option;
  }
}

TEST(InstalledProgram, ShellsReadTheirCompletion) {
  must_run({"bash", "-n", "share/bash-completion/completions/taut"}, prefix());
  if (Child({"sh", "-c", "command -v zsh"}, prefix()).wait().code == 0) {
    must_run({"zsh", "-n", "share/zsh/vendor-completions/_taut"}, prefix());
  }
  if (Child({"sh", "-c", "command -v fish"}, prefix()).wait().code == 0) {
    must_run({"fish", "-n", "share/fish/vendor_completions.d/taut.fish"}, prefix());
  }
}

TEST(InstalledProgram, DemoSaysWhereItLookedForItsScene) {
  Folder folder;  // with the program alone, in no prefix
  fs::copy(program(), folder.path() / "taut");
  const ProgramResult outcome = Child({"./taut", "demo"}, folder.path()).wait();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("there is no file \"scenes/nunchaku.toml\"; looked: "),
            std::string::npos)
      << outcome.messages;
}

TEST(LongInstalledProgram, DemoMakesAPictureAndASmallClipInAnEmptyFolder) {
  Folder folder;
  const ProgramResult outcome = must_run({program(), "demo", "--preview", "-q"}, folder.path());
  EXPECT_EQ(outcome.output, "out/nunchaku/preview/poster.png\nout/nunchaku/preview/nunchaku.mp4\n");
  EXPECT_GT(fs::file_size(folder.path() / "out/nunchaku/preview/poster.png"), 100000u);
  EXPECT_GT(fs::file_size(folder.path() / "out/nunchaku/preview/nunchaku.mp4"), 10000u);
}

}  // namespace
}  // namespace taut
