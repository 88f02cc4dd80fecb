// Progress of long work on standard error, and the terminal it is written to.
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <string>

#include "render/chart/table.h"

namespace taut::program {

// The terminal that results go to: its width and its colours.

/// True where words on this stream (1 or 2) may be coloured: on a terminal unless NO_COLOR says
/// otherwise, and wherever CLICOLOR_FORCE does.
bool is_colored(int stream);

/// The table as standard output shows it: in lines no wider than the terminal, or than COLUMNS
/// says, the names of its columns bold where there are colours. A pipe or file gets whole lines.
std::string table_text(const chart::Table& table);

class Progress {
 public:
  /// `what` as in "rendering", `unit` as in "frames". Silent when `quiet`.
  Progress(std::string what, std::string unit, std::uint64_t total, bool quiet);
  /// Clears the live line. Where an interruption ends the work, left_off() tells of it.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Says that `done` of the total are finished.
  void update(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_, unit_;
  std::uint64_t total_, done_ = 0;
  int exceptions_ = std::uncaught_exceptions();
  bool quiet_, terminal_;
  bool shown_ = false;
  Clock::time_point start_, last_;
};

/// How far the innermost work was that an interruption ended: "simulating: 3 of 60 frames". Empty
/// where none was.
const std::string& left_off();

/// A duration as h:mm:ss or m:ss.
std::string clock_text(double seconds);

}  // namespace taut::program
