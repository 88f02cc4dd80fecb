// Ending long work from outside, and the CPU time that it takes.
#pragma once

#include <cstdint>
#include <exception>
#include <limits>

namespace taut {

/// Returns where work may continue; throws, whatever it likes, to end it. May be called by several
/// threads at once.
using StopCheck = void (*)();

/// Every long computation of the process calls `check` from now on, between steps and between
/// iterations; null, the default, for none. A simulation that it ended within a step cannot
/// continue (see Simulation::advance_to()).
void set_stop_check(StopCheck check);

/// Calls the check and looks at the thread's WorkLimit. Without any it costs an atomic read. Throws
/// what the check throws, and OverLimit.
void check_stop();

/// Work was ended by a WorkLimit.
class OverLimit : public std::exception {
 public:
  const char* what() const noexcept override { return "the work is over its limit"; }
};

/// While it lives, check_stop() throws OverLimit on the thread that made it once the work since
/// then is more than allowed. Limits nest; the inner one goes first.
class WorkLimit {
 public:
  struct Most {
    double cpu_time = std::numeric_limits<double>::infinity();  // s, of the thread
    /// Calls of check_stop(): as many on every machine.
    std::uint64_t checks = std::numeric_limits<std::uint64_t>::max();
  };
  explicit WorkLimit(const Most& most);
  ~WorkLimit();
  WorkLimit(const WorkLimit&) = delete;
  WorkLimit& operator=(const WorkLimit&) = delete;

  /// True once it threw: else an OverLimit is that of a limit around it.
  bool reached() const { return reached_; }

 private:
  friend void check_stop();
  void check();

  Most most_;
  WorkLimit* outer_;
  double end_ = 0;           // s, of the thread's CPU time
  std::int64_t looked_ = 0;  // ns, of the system's coarse clock
  std::uint64_t checks_ = 0;
  bool reached_ = false;
};

/// CPU time (s) of the calling thread.
double thread_seconds();

}  // namespace taut
