// Progress of long work on standard error: one live line on a terminal, a plain line now and then
// elsewhere (a log, a pipe).
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace taut::cli {

class Progress {
 public:
  /// `what` as in "rendering", `unit` as in "frames". Silent when `quiet`.
  Progress(std::string what, std::string unit, std::uint64_t total, bool quiet);
  /// Clears the live line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Says that `done` of the total are finished.
  void update(std::uint64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_, unit_;
  std::uint64_t total_;
  bool quiet_, terminal_;
  bool shown_ = false;
  Clock::time_point start_, last_;
};

/// A duration as h:mm:ss or m:ss.
std::string clock_text(double seconds);

}  // namespace taut::cli
