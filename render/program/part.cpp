#include "render/program/part.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/base/interrupt.h"
#include "render/program/output.h"
#include "scenes/files/files.h"

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

namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "parts";

/// Reads a positive number and what stands behind it; 0 where there is none.
std::size_t number_before(std::string_view& text, std::string_view mark) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view rest(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (error != std::errc() || !rest.starts_with(mark)) return 0;
  text = rest.substr(mark.size());
  return value;
}

/// Rising numbers as "3, 7-9".
std::string ranges_text(const std::set<std::size_t>& numbers) {
  std::string text;
  for (auto i = numbers.begin(); i != numbers.end();) {
    const std::size_t first = *i;
    std::size_t last = first;
    while (++i != numbers.end() && *i == last + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", first);
    if (last > first) text += fmt::format("-{}", last);
  }
  return text;
}

std::vector<fs::path> paths_of(const std::vector<PartPath>& parts) {
  std::vector<fs::path> paths;
  for (const PartPath& part : parts) paths.push_back(part.path);
  return paths;
}

}  // namespace

void add_part_options(Command& command, PartOptions& options, const std::string& whole) {
  const auto read = [&options](const std::string& text) {
    std::string_view rest = text;
    options.number = number_before(rest, "/");
    options.count = number_before(rest, "");
    if (options.number == 0 || options.number > options.count || !rest.empty()) {
      throw Misuse(text + ": expected K/N with K from 1 to N, as in 3/100");
    }
  };
  const Option part =
      command
          .add_text(
              "--part", read,
              fmt::format("Do only the K-th of N parts of the {}, on any machine; for --merge",
                          whole))
          .type_name("K/N");
  command
      .add_flag("--merge", options.merge,
                fmt::format("Only combine the {} of all parts into the result", whole))
      .excludes(part);
}

std::size_t part_of(std::size_t piece, std::size_t total, std::size_t count, Share share) {
  if (share == Share::in_turn) return piece % count + 1;
  // Part k has the pieces from floor((k - 1) total / count) to floor(k total / count).
  return ((piece + 1) * count + total - 1) / total;
}

std::vector<std::size_t> pieces_of(const PartOptions& part, std::size_t total, Share share) {
  std::vector<std::size_t> pieces;
  for (std::size_t i = 0; i < total; ++i) {
    if (part_of(i, total, part.count, share) == part.number) pieces.push_back(i);
  }
  return pieces;
}

PartPath part_path(const fs::path& folder, const std::string& name, const PartOptions& part) {
  return {folder / kFolder / fmt::format("{}.{}-of-{}", name, part.number, part.count), part.number,
          part.count};
}

std::vector<PartPath> found_parts(const fs::path& folder, const std::string& name) {
  std::vector<PartPath> parts;
  std::error_code error;
  for (fs::directory_iterator entry(folder / kFolder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file = entry->path().filename().string();
    if (!file.starts_with(name + ".")) continue;
    std::string_view rest = std::string_view(file).substr(name.size() + 1);
    const std::size_t number = number_before(rest, "-of-"), count = number_before(rest, "");
    if (number > 0 && count > 0 && rest.empty()) parts.push_back({entry->path(), number, count});
  }
  if (error && error != std::errc::no_such_file_or_directory) {
    throw render::CannotWrite(fmt::format("{}: {}", (folder / kFolder).string(), error.message()));
  }
  std::ranges::sort(parts, {},
                    [](const PartPath& part) { return std::pair(part.count, part.number); });
  return parts;
}

void require_all(const std::vector<std::size_t>& missing, std::size_t total, Share share,
                 const std::vector<PartPath>& found, const fs::path& folder,
                 const std::string& unit) {
  if (missing.empty()) return;
  std::set<std::size_t> counts, numbers;
  for (const PartPath& part : found) counts.insert(part.count);
  std::string who;
  if (counts.size() == 1) {
    for (const std::size_t piece : missing) {
      numbers.insert(part_of(piece, total, *counts.begin(), share));
    }
    who = fmt::format("; not done, or of another scene, program or other options: part{} {} of {}",
                      numbers.size() > 1 ? "s" : "", ranges_text(numbers), *counts.begin());
  } else if (found.empty()) {
    who = "; no part has begun (--part K/N)";
  }
  throw Misuse(fmt::format("--merge: {} lacks {} of {} {}{}", (folder / kFolder).string(),
                           missing.size(), total, unit, who));
}

int do_part(const PartOptions& part, const Pieces& pieces, const fs::path& folder,
            std::uint64_t stamp, const Common& common,
            const std::function<std::vector<std::string>(std::size_t, Journal&)>& work) {
  const fs::path file = part_path(folder, pieces.name, part).path;
  Journal journal(file, stamp);
  const std::vector<std::size_t> own = pieces_of(part, pieces.keys.size(), pieces.share);
  {
    Progress progress(fmt::format("part {}/{}", part.number, part.count), pieces.unit, own.size(),
                      common.quiet);
    std::size_t done = 0;
    for (const std::size_t i : own) {
      render::stop_if_interrupted();
      if (!journal.find(pieces.keys[i])) journal.add(pieces.keys[i], work(i, journal));
      progress.update(++done);
    }
  }
  return say_part_done(part, file, own.size(), common);
}

Journal merged_journal(const Pieces& pieces, const fs::path& folder, std::uint64_t stamp) {
  const std::vector<PartPath> found = found_parts(folder, pieces.name);
  Journal journal(paths_of(found), stamp);
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < pieces.keys.size(); ++i) {
    if (!journal.find(pieces.keys[i])) missing.push_back(i);
  }
  require_all(missing, pieces.keys.size(), pieces.share, found, folder, pieces.unit);
  return journal;
}

int say_part_done(const PartOptions& part, const fs::path& path, std::size_t pieces,
                  const Common& common) {
  const nlohmann::ordered_json report = {
      {"part", part.number}, {"parts", part.count}, {"pieces", pieces}, {"path", path.string()}};
  render::write_output(common.json ? json_text(report) + "\n" : path.string() + "\n");
  return kDone;
}

}  // namespace taut::program
