#include "render/cli/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "render/error.h"

namespace taut::cli {
namespace {

// Fields end with tabs, rows with newlines; neither stands in a key or cell.
constexpr char kField = '\t';

std::string plain(std::string text) {
  for (char& c : text) {
    if (c == kField || c == '\n') c = ' ';
  }
  return text;
}

std::string header(std::uint64_t stamp) {
  return fmt::format("taut study {:016x}", stamp);
}

}  // namespace

Journal::Journal(std::filesystem::path file, std::uint64_t stamp) : name_(std::move(file)) {
  std::error_code error;
  if (name_.has_parent_path()) std::filesystem::create_directories(name_.parent_path(), error);
  file_ = open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND, 0644);
  if (file_ < 0) fail("cannot be created");
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    close(file_);
    throw CannotWrite(fmt::format("{}: another run is writing it", name_.string()));
  }
  read(stamp);
}

Journal::~Journal() {
  if (file_ >= 0) close(file_);
}

void Journal::read(std::uint64_t stamp) {
  std::ifstream in(name_, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  std::string text = all.str();
  text.resize(text.rfind('\n') + 1);  // npos + 1 is zero
  std::istringstream lines(text);
  std::string line;
  if (!std::getline(lines, line) || line != header(stamp)) text.clear();
  if (ftruncate(file_, static_cast<off_t>(text.size())) != 0) fail("cannot be cut");
  if (text.empty()) {
    line = header(stamp) + "\n";
    if (write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
      fail("cannot be written");
    }
    return;
  }
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::string cell;
    for (std::istringstream fields(line); std::getline(fields, cell, kField);) {
      cells.push_back(cell);
    }
    if (cells.empty()) continue;
    std::string key = std::move(cells.front());
    cells.erase(cells.begin());
    rows_[std::move(key)] = std::move(cells);
  }
  kept_ = rows_.size();
}

const std::vector<std::string>* Journal::find(const std::string& key) const {
  const auto row = rows_.find(plain(key));
  return row == rows_.end() ? nullptr : &row->second;
}

void Journal::add(const std::string& key, const std::vector<std::string>& cells) {
  std::string line = plain(key);
  for (const std::string& cell : cells) line += kField + plain(cell);
  line += kField;  // keeps an empty last cell
  line += '\n';
  if (write(file_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    fail("cannot be written");
  }
  rows_[plain(key)] = cells;
}

void Journal::finish() {
  unlink(name_.c_str());
  close(file_);
  file_ = -1;
}

void Journal::fail(const char* action) const {
  throw CannotWrite(fmt::format("{}: {}: {}", name_.string(), action, std::strerror(errno)));
}

std::string exact(double value) {
  return fmt::format("{:.17g}", value);
}

double number_in(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

}  // namespace taut::cli
