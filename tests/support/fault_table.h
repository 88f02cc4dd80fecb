// The table of faults: what was wrong, what taut said, how it ended. The tests make it, section by
// section; it is kept in tests/faults.md, so that a change of any message is seen.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "sim/run/method.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {

class FaultTable {
 public:
  /// One section of the table. `folder` is where the tests' files lie.
  FaultTable(std::string title, const std::filesystem::path& folder)
      : title_(std::move(title)), folder_(folder.string()) {}

  void add(const std::string& fault, const ProgramResult& outcome) {
    std::string message = outcome.messages;
    // The folder's name is another one each time, the source's on each machine, and methods come
    // and go.
    replace(message, folder_, "FOLDER");
    replace(message, TAUT_SOURCE_DIR, "SOURCE");
    replace(message, method_names(), "METHODS");
    // Steps follow from errors down to their roundings, which processors make otherwise.
    message = std::regex_replace(message, std::regex("\\(step [0-9]+"), "(step N");
    rows_ += fmt::format("| {} | `{}` | {} |\n", cell(fault), cell(message), outcome.code);
  }

  /// True where every row stands in the section in tests/faults.md.
  testing::AssertionResult is_part_of_accepted() const {
    const std::string text = read_file(TAUT_SOURCE_DIR "/tests/faults.md");
    const std::size_t begin = std::min(text.find(fmt::format("## {}\n", title_)), text.size());
    const std::string section = text.substr(begin, text.find("## ", begin + 1) - begin);
    std::istringstream rows(rows_);
    for (std::string row; std::getline(rows, row);)
      if (section.find(row + '\n') == std::string::npos)
        return testing::AssertionFailure() << "no row of \"" << title_ << "\": " << row;
    return testing::AssertionSuccess();
  }

  /// Compares with the section in tests/faults.md; with TAUT_ACCEPT in the environment, writes it
  /// there instead.
  testing::AssertionResult is_as_accepted() const {
    const std::filesystem::path file = TAUT_SOURCE_DIR "/tests/faults.md";
    std::string text = read_file(file);
    const std::string heading = fmt::format("## {}\n", title_);
    const std::string section =
        heading + "\n| fault | message | exit code |\n|---|---|---|\n" + rows_ + '\n';
    const std::size_t begin = std::min(text.find(heading), text.size());
    const std::size_t end = std::min(text.find("## ", begin + 1), text.size());
    if (text.substr(begin, end - begin) == section) return testing::AssertionSuccess();
    if (std::getenv("TAUT_ACCEPT")) {
      std::ofstream(file) << text.replace(begin, end - begin, section);
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure()
           << "not as in " << file << ". Look at it; if it is right, run this test with "
           << "TAUT_ACCEPT=1 in the environment. Now the section is:\n"
           << section;
  }

 private:
  static void replace(std::string& text, const std::string& part, std::string_view with) {
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += with.size()) {
      text.replace(at, part.size(), with);
    }
  }

  static std::string method_names() {
    std::string names;
    for (const MethodInfo& method : all_methods()) {
      names += (names.empty() ? "" : ", ") + std::string(method.name);
    }
    return names;
  }

  /// A text as a cell: one line, without what Markdown reads, only plain characters.
  static std::string cell(const std::string& text) {
    std::string line;
    for (const char c : text) {
      if (c == '|') {
        line += "\\|";
      } else if (c == '\n') {
        line += ' ';
      } else {
        line += c >= ' ' && c <= '~' ? c : '?';
      }
    }
    while (line.ends_with(' ')) line.pop_back();
    return line;
  }

  std::string title_, folder_, rows_;
};

}  // namespace taut
