#include "render/program/part.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "render/base/interrupt.h"
#include "render/program/json.h"
#include "render/program/note.h"
#include "render/program/progress.h"

namespace taut::program {
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
          .add_text("--part", read,
                    fmt::format("Only the K-th of N shares of the {}, for --merge: on any machine",
                                whole))
          .type_name("K/N");
  command
      .add_flag("--merge", options.merge,
                fmt::format("The result from the {} that all parts made; does none itself", whole))
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
