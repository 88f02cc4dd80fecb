#include "sim/motion/stop.h"

#include <atomic>
#include <cmath>
#include <ctime>

namespace taut {
namespace {

std::atomic<StopCheck> stop_check = nullptr;
thread_local WorkLimit* innermost = nullptr;

std::int64_t nanoseconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

void set_stop_check(StopCheck check) {
  stop_check.store(check, std::memory_order_relaxed);
}

void check_stop() {
  if (const StopCheck check = stop_check.load(std::memory_order_relaxed)) check();
  for (WorkLimit* limit = innermost; limit; limit = limit->outer_) limit->check();
}

WorkLimit::WorkLimit(const Most& most)
    : most_(most), outer_(innermost), end_(thread_seconds() + most.cpu_time) {
  innermost = this;
}

WorkLimit::~WorkLimit() {
  innermost = outer_;
}

void WorkLimit::check() {
  if (++checks_ > most_.checks) reached_ = true;
  if (std::isfinite(most_.cpu_time)) {
    // A look at the thread's clock costs far more than one at the coarse clock, which stands still
    // for some milliseconds.
    const std::int64_t now = nanoseconds(CLOCK_MONOTONIC_COARSE);
    if (now != looked_ && thread_seconds() > end_) reached_ = true;
    looked_ = now;
  }
  if (reached_) throw OverLimit();
}

double thread_seconds() {
  return 1e-9 * static_cast<double>(nanoseconds(CLOCK_THREAD_CPUTIME_ID));
}

}  // namespace taut
