#include "tests/bad_input/fault_table.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "sim/method.h"
#include "tests/support/folder.h"

namespace taut {

namespace {

/// A message as a cell: one line, nothing that Markdown reads, no byte that is not plain.
std::string cell(std::string text) {
  std::string line;
  for (const char c : text) {
    if (c == '|') {
      line += "\\|";
    } else if (c == '\n') {
      line += line.empty() ? "" : " ";
    } else {
      line += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

void replace(std::string& text, const std::string& part, std::string_view with) {
  for (std::size_t at; (at = text.find(part)) != std::string::npos;) {
    text.replace(at, part.size(), with);
  }
}

std::string method_names() {
  std::string names;
  for (const MethodInfo& method : methods()) {
    names += (names.empty() ? "" : ", ") + std::string(method.name);
  }
  return names;
}

}  // namespace

void FaultTable::add(const std::string& fault, const Outcome& outcome) {
  std::string message = outcome.messages;
  // The folder's name is another one each time, and methods come and go.
  replace(message, folder_, "FOLDER");
  replace(message, method_names(), "METHODS");
  rows_ += fmt::format("| {} | `{}` | {} |\n", cell(fault), cell(message), outcome.code);
}

testing::AssertionResult FaultTable::is_as_accepted(const std::string& name) const {
  const auto file =
      std::filesystem::path(TAUT_SOURCE_DIR) / "tests/bad_input/faults" / (name + ".md");
  const std::string text =
      fmt::format("# {}\n\n| fault | message | exit code |\n|---|---|---|\n{}", title_, rows_);
  if (std::getenv("TAUT_ACCEPT")) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
    return testing::AssertionSuccess();
  }
  if (read_file(file) == text) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << "the messages differ from " << file
         << "; look at them, then run the test with TAUT_ACCEPT=1. Now they are:\n"
         << text;
}

}  // namespace taut
