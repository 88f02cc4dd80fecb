// Work that several processes share, and the journal by which a stopped study goes on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "render/base/atomic_file.h"
#include "render/program/command.h"

namespace taut::program {

// The results of a long study so far, on the disk, so that a run that was stopped goes on.

/// Rows of text under a key each. A row is on the disk when add() returns; a row that a crash cut
/// short is forgotten.
class Journal {
 public:
  /// Takes up the rows of `file` where it was written under the same `stamp`: of everything that
  /// decides what the rows say. Starts anew otherwise. Throws CannotWrite, also when another run is
  /// writing it.
  Journal(std::filesystem::path file, std::uint64_t stamp);
  /// Only to look up: the rows of those `files` that were written under the stamp, of two under a
  /// key that of the later file. Throws BadAsset where one cannot be read.
  Journal(const std::vector<std::filesystem::path>& files, std::uint64_t stamp);

  /// The row's cells, or null.
  const std::vector<std::string>* find(const std::string& key) const;
  /// Throws CannotWrite.
  void add(const std::string& key, const std::vector<std::string>& cells);
  /// How many rows were taken up.
  std::size_t kept() const { return kept_; }
  /// Removes the file: the study is complete, and its next run starts anew. Throws
  /// CannotWrite.
  void finish();

 private:
  [[noreturn]] void fail(const char* action) const;
  bool take_up(const std::string& text, std::uint64_t stamp);

  std::filesystem::path name_;
  render::Descriptor file_;
  std::size_t kept_ = 0;
  std::map<std::string, std::vector<std::string>> rows_;
};

/// A number as text that reads back as the same number, infinities and not-a-number included.
std::string exact(double value);
double number_in(const std::string& text);

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
