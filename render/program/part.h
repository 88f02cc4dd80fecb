// Work that several processes share out, each a part of it, and the merge of what they did.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/program/command.h"
#include "render/program/journal.h"

namespace taut::program {

struct PartOptions {
  std::size_t number = 0, count = 0;  // --part number/count; 0: all of it
  bool merge = false;                 // --merge

  bool is_part() const { return number > 0; }
};

/// --part K/N and --merge. `whole` is what there is to share out: "runs".
void add_part_options(Command& command, PartOptions& options, const std::string& whole);

/// Which pieces of work a part has: neighbours, where those need the same preparation; every n-th,
/// where their costs differ.
enum class Share { neighbours, in_turn };

/// The part, from 1, of `count` that a piece of `total` belongs to. Parts of neighbours differ in
/// size by one piece at most.
std::size_t part_of(std::size_t piece, std::size_t total, std::size_t count, Share share);
/// The pieces of a part, rising.
std::vector<std::size_t> pieces_of(const PartOptions& part, std::size_t total, Share share);

/// The output of a part of a command: FOLDER/parts/NAME.K-of-N.
struct PartPath {
  std::filesystem::path path;
  std::size_t number = 0, count = 0;
};
PartPath part_path(const std::filesystem::path& folder, const std::string& name,
                   const PartOptions& part);
/// All of that name that are there, by count and number.
std::vector<PartPath> found_parts(const std::filesystem::path& folder, const std::string& name);

/// Throws Misuse where pieces of `total` are missing in the parts found, and names the parts that
/// would do them. `unit` is what pieces are called: "runs".
void require_all(const std::vector<std::size_t>& missing, std::size_t total, Share share,
                 const std::vector<PartPath>& found, const std::filesystem::path& folder,
                 const std::string& unit);

/// The pieces of work of a study: the keys of their rows, and how they are shared out.
struct Pieces {
  std::string name;  // of the journals
  std::string unit;  // "runs"
  Share share = Share::in_turn;
  std::vector<std::string> keys;
};

/// Does the pieces of a part that its journal in `folder` lacks: work(i, journal) makes the row of
/// piece i. Says on standard output where the rows are.
int do_part(const PartOptions& part, const Pieces& pieces, const std::filesystem::path& folder,
            std::uint64_t stamp, const Common& common,
            const std::function<std::vector<std::string>(std::size_t, Journal&)>& work);

/// The rows of all parts in `folder` that were written under the stamp. Throws Misuse where a piece
/// is missing.
Journal merged_journal(const Pieces& pieces, const std::filesystem::path& folder,
                       std::uint64_t stamp);

/// The words on standard output of a part that is done.
int say_part_done(const PartOptions& part, const std::filesystem::path& path, std::size_t pieces,
                  const Common& common);

}  // namespace taut::program
