// Every command in the `sh` blocks of the README files exists, with its options and files; the
// short forms beside them run.
#include <fmt/format.h>
#include <glob.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

const std::filesystem::path kSource = TAUT_SOURCE_DIR;
const std::filesystem::path kBuild = std::filesystem::path(TAUT_PROGRAM).parent_path();

/// README.md files, without those of what is built or written.
std::vector<std::filesystem::path> pages() {
  std::vector<std::filesystem::path> found{kSource / "README.md"};
  for (const char* room : {"assets", "render", "scenes", "sim", "tests"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(kSource / room)) {
      if (entry.path().filename() == "README.md") found.push_back(entry.path());
    }
  }
  return found;
}

struct Page {
  std::vector<std::string> commands, quick;
  std::vector<std::string> measured;  // behind results
};

/// The commands of a line, with `&&` or `;` between them.
void split(const std::string& line, std::vector<std::string>& commands) {
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t end = line.find_first_of("&;", at);
    commands.push_back(line.substr(at, end == std::string::npos ? end : end - at));
    at = line.find_first_not_of("&;", end);
  }
}

/// The commands of the page's `sh` blocks and its short forms.
Page read_page(const std::string& text) {
  Page page;
  std::istringstream in(text);
  bool inside = false;
  const std::string mark = "<!-- quick: ";
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) {
      inside = !inside && line == "```sh";
    } else if (line.starts_with(mark)) {
      split(line.substr(mark.size(), line.rfind(" -->") - mark.size()), page.quick);
    } else if (line.starts_with("*Measured")) {
      for (std::size_t at = line.find('`'); at != std::string::npos;) {
        const std::size_t end = line.find('`', at + 1);
        page.measured.push_back(line.substr(at + 1, end - at - 1));
        at = line.find('`', end + 1);
      }
    } else if (inside) {
      line = line.substr(0, line.find(" #"));
      split(line, page.commands);
    }
  }
  return page;
}

/// Words of a command without its assignments and its quotes.
std::vector<std::string> words_of(const std::string& command) {
  std::istringstream in(command);
  std::vector<std::string> words;
  for (std::string word; in >> word;) {
    std::erase_if(word, [](char c) { return c == '\'' || c == '"'; });
    const bool assignment = words.empty() && word.find('=') != std::string::npos;
    if (word.starts_with("SUDO=$(")) return {};
    if (!assignment && word != "$SUDO" && word != "sudo") words.push_back(word);
  }
  return words;
}

/// The program that the first word names, or nothing where a program of the system is meant.
std::filesystem::path program_of(const std::string& word) {
  if (word == "taut" || word == "$taut") return TAUT_PROGRAM;
  for (const auto& folder : {kBuild, kBuild / "tests/bench"}) {
    if (word.starts_with("taut_") && std::filesystem::exists(folder / word)) return folder / word;
  }
  for (const auto& [prefix, folder] :
       {std::pair<std::string, std::filesystem::path>{"build/release/", kBuild},
        {"build/fuzz/", {}},
        {"", kSource}}) {
    if (!word.starts_with(prefix) || word.find('/') == std::string::npos) continue;
    if (folder.empty()) return {};  // built by another preset
    if (word == "build/release/taut") return TAUT_PROGRAM;
    return folder / word.substr(prefix.size());
  }
  return {};
}

const std::set<std::string> kOfTheSystem{"apt-get", "cmake",  "ctest", "dpkg-query",
                                         "du",      "ffmpeg", "git",   "gnuplot",
                                         "make",    "mkdir",  "ninja", "/usr/bin/python3"};

bool is_preset(const std::string& name) {
  const auto json = nlohmann::json::parse(read_file(kSource / "CMakePresets.json"));
  for (const char* kind : {"configurePresets", "workflowPresets", "testPresets"}) {
    for (const auto& preset : json.at(kind)) {
      if (preset.at("name") == name) return true;
    }
  }
  return false;
}

/// Files of the repository that a command reads must be there; patterns must match some.
bool is_missing(const std::string& word) {
  if (!word.starts_with("scenes/") && !word.starts_with("tests/") && !word.starts_with("assets/"))
    return false;
  glob_t found{};
  const int code = glob((kSource / word).c_str(), 0, nullptr, &found);
  globfree(&found);
  return code != 0;
}

/// The text of --help, asked once.
const std::string& help_of(const std::vector<std::string>& command) {
  static std::map<std::vector<std::string>, std::string> asked;
  const auto [at, is_new] = asked.try_emplace(command);
  if (is_new) {
    std::vector<std::string> words = command;
    words.push_back("--help");
    const ProgramResult result = Child(words, kSource).wait();
    if (result.code == 0) at->second = result.output;
  }
  return at->second;
}

/// The option stands in a text of help, and not only as the beginning of another.
bool has_option(const std::string& help, const std::string& option) {
  for (std::size_t at = help.find(option); at != std::string::npos;
       at = help.find(option, at + 1)) {
    const char after = at + option.size() < help.size() ? help[at + option.size()] : ' ';
    if (!std::isalnum(static_cast<unsigned char>(after)) && after != '-') return true;
  }
  return false;
}

/// The fault of a command, or empty.
std::string complaint(const std::vector<std::string>& words) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    const bool written = words[i - 1] == "--out" || words[i - 1] == "--csv";
    if (!written && is_missing(words[i])) return "there is no " + words[i];
    if (words[i - 1] == "--preset" && !is_preset(words[i])) return "there is no preset " + words[i];
  }
  const std::filesystem::path program = program_of(words[0]);
  if (program.empty()) {
    const bool built_elsewhere = words[0].starts_with("build/");
    return built_elsewhere || kOfTheSystem.contains(words[0]) ? "" : "is no program that is known";
  }
  if (!std::filesystem::exists(program)) return "there is no " + program.string();
  std::vector<std::string> command{program.string()};
  const bool has_commands = program == TAUT_PROGRAM || program.filename() == "taut_engines";
  if (has_commands && words.size() > 1) command.push_back(words[1]);
  const std::string& help = help_of(command);
  if (help.empty()) return "cannot be run with --help";
  if (command.size() > 1 && help == help_of({command[0]})) return "has no command " + command[1];
  for (const std::string& word : words) {
    const std::string option = word.substr(0, word.find('='));
    if (word.starts_with("--") && !has_option(help, option)) return "has no option " + option;
  }
  return "";
}

TEST(ReadmeCommands, ExistWithTheirOptionsAndFiles) {
  std::size_t checked = 0;
  for (const auto& file : pages()) {
    const Page page = read_page(read_file(file));
    for (const auto* commands : {&page.commands, &page.measured}) {
      for (const std::string& command : *commands) {
        const std::vector<std::string> words = words_of(command);
        if (words.empty()) continue;
        ++checked;
        EXPECT_EQ(complaint(words), "") << file << ": " << command;
      }
    }
  }
  EXPECT_GT(checked, 30U);
}

TEST(ReadmeCommands, MistakesAreSeen) {
  EXPECT_NE(complaint({"$taut", "rendr", "scenes/pin.toml"}), "");
  EXPECT_NE(complaint({"$taut", "render", "scenes/no_such.toml"}), "");
  EXPECT_NE(complaint({"$taut", "render", "scenes/pin.toml", "--no-vid"}), "");
  EXPECT_NE(complaint({"cmake", "--preset", "releas"}), "");
  EXPECT_NE(complaint({"build/release/taut_promises"}), "");
  EXPECT_NE(complaint({"tautt", "render"}), "");
  EXPECT_EQ(complaint({"$taut", "render", "scenes/*.toml", "--no-video"}), "");
}

TEST(ReadmeCommands, ShortFormsRun) {
  const Folder folder;
  for (const auto& file : pages()) {
    for (std::string command : read_page(read_file(file)).quick) {
      while (command.find("FOLDER") != std::string::npos) {
        command.replace(command.find("FOLDER"), 6, folder.path().string());
      }
      std::vector<std::string> words = words_of(command);
      ASSERT_FALSE(words.empty()) << file << ": " << command;
      words[0] = program_of(words[0]).string();
      const ProgramResult result = Child(words, kSource).wait();
      EXPECT_EQ(result.code, 0) << file << ": " << command << "\n" << result.messages;
    }
  }
}

/// The program that a command runs and, of programs of several commands, which; empty for others'.
std::string name_of(const std::string& command) {
  const std::vector<std::string> words = words_of(command);
  if (words.empty() || kOfTheSystem.contains(words[0])) return "";
  const std::filesystem::path program = program_of(words[0]);
  if (program.empty()) return "";
  const bool named = words.size() > 1 && !words[1].starts_with("-") &&
                     (program == TAUT_PROGRAM || program.filename() == "taut_engines");
  return program.filename().string() + (named ? " " + words[1] : "");
}

TEST(ReadmeCommands, HaveShortForms) {
  std::set<std::string> shown, run;
  for (const auto& file : pages()) {
    const Page page = read_page(read_file(file));
    for (const std::string& command : page.commands) shown.insert(name_of(command));
    for (const std::string& command : page.quick) run.insert(name_of(command));
  }
  shown.erase("");
  for (const std::string& name : shown) {
    const bool is_test = name.starts_with("test_");  // CTest runs those
    EXPECT_TRUE(is_test || run.contains(name)) << name;
  }
}

/// Pages link to each other.
TEST(ReadmeCommands, LinkedFilesAreThere) {
  for (const auto& file : pages()) {
    const std::string text = read_file(file);
    for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 2)) {
      std::string target = text.substr(at + 2, text.find(')', at) - at - 2);
      target = target.substr(0, target.find('#'));
      if (target.empty() || target.find("://") != std::string::npos) continue;
      EXPECT_TRUE(std::filesystem::exists(file.parent_path() / target)) << file << ": " << target;
    }
  }
}

TEST(Readme, IsShort) {
  const std::string text = read_file(kSource / "README.md");
  EXPECT_LE(std::ranges::count(text, '\n'), 120);
}

/// Every result has its place, with machine, date and commit; what no clock measures is up to date.
TEST(Readme, ResultsAreThoseOfTheirCommands) {
  const ProgramResult result =
      Child({"python3", "tests/bench/results.py", "--check", "--build", kBuild.string()}, kSource)
          .wait();
  EXPECT_EQ(result.code, 0) << result.messages;
}

}  // namespace
}  // namespace taut
