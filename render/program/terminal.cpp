#include "render/program/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <string_view>

namespace taut::program {
namespace {

/// The value of a variable; empty where there is none.
std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::size_t output_width() {
  const std::string_view columns = environment("COLUMNS");
  std::size_t width = 0;
  std::from_chars(columns.data(), columns.data() + columns.size(), width);
  if (width > 0) return width;
  winsize size{};
  if (isatty(STDOUT_FILENO) && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    return size.ws_col;
  }
  return std::numeric_limits<std::size_t>::max();
}

}  // namespace

bool is_colored(int stream) {
  if (!environment("NO_COLOR").empty()) return false;
  const std::string_view force = environment("CLICOLOR_FORCE");
  if (!force.empty() && force != "0") return true;
  return isatty(stream) && environment("TERM") != "dumb";
}

std::string table_text(const chart::Table& table) {
  const std::string text = chart::to_text(table, output_width());
  if (!is_colored(STDOUT_FILENO)) return text;
  // The first line of the table, or of each of its paragraphs.
  std::string colored;
  bool first = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    colored += first && !line.empty() ? "\033[1m" + line + "\033[0m\n" : line + "\n";
    first = line.empty();
    begin = end + 1;
  }
  return colored;
}

}  // namespace taut::program
