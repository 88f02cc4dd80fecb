#include "render/program/journal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "scenes/files/regular_file.h"

namespace taut::program {
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

/// The file's text without a line that was cut short.
std::string whole_lines(const std::filesystem::path& file) {
  std::string text = scenes::read_bytes(file);
  text.resize(text.rfind('\n') + 1);  // npos + 1 is zero
  return text;
}

}  // namespace

Journal::Journal(std::filesystem::path file, std::uint64_t stamp) : name_(std::move(file)) {
  std::error_code error;
  if (name_.has_parent_path()) std::filesystem::create_directories(name_.parent_path(), error);
  if (error) {
    throw render::CannotWrite(
        fmt::format("{}: cannot be created: {}", name_.string(), error.message()));
  }
  file_ = render::Descriptor(open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND, 0644));
  if (!file_.is_open()) fail("cannot be created");
  if (!render::try_to_lock(file_.get(), name_)) {
    throw render::CannotWrite(fmt::format("{}: another run is writing it", name_.string()));
  }
  const std::string text = whole_lines(name_);
  const bool known = take_up(text, stamp);
  if (ftruncate(file_.get(), static_cast<off_t>(known ? text.size() : 0)) != 0)
    fail("cannot be cut");
  if (!known && !render::write_all(file_.get(), header(stamp) + "\n")) fail("cannot be written");
  kept_ = rows_.size();
}

Journal::Journal(const std::vector<std::filesystem::path>& files, std::uint64_t stamp) {
  for (const auto& file : files) take_up(whole_lines(file), stamp);
  kept_ = rows_.size();
}

/// Takes the rows of a journal's text; false where it was written under another stamp.
bool Journal::take_up(const std::string& text, std::uint64_t stamp) {
  std::istringstream lines(text);
  lines.exceptions(std::ios::badbit);  // or running out of memory would end the text
  std::string line;
  if (!std::getline(lines, line) || line != header(stamp)) return false;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::string cell;
    std::istringstream fields(line);
    fields.exceptions(std::ios::badbit);
    while (std::getline(fields, cell, kField)) cells.push_back(cell);
    if (cells.empty()) continue;
    std::string key = std::move(cells.front());
    cells.erase(cells.begin());
    rows_[std::move(key)] = std::move(cells);
  }
  return true;
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
  if (!render::write_all(file_.get(), line)) fail("cannot be written");
  rows_[plain(key)] = cells;
}

void Journal::finish() {
  render::remove_output(name_);
  file_.close();
}

void Journal::fail(const char* action) const {
  throw render::CannotWrite(
      fmt::format("{}: {}: {}", name_.string(), action, std::strerror(errno)));
}

std::string exact(double value) {
  return fmt::format("{:.17g}", value);
}

double number_in(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

}  // namespace taut::program
