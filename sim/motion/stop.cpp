#include "sim/motion/stop.h"

#include <atomic>

namespace taut {
namespace {

std::atomic<StopCheck> stop_check = nullptr;

}  // namespace

void set_stop_check(StopCheck check) {
  stop_check.store(check, std::memory_order_relaxed);
}

void check_stop() {
  if (const StopCheck check = stop_check.load(std::memory_order_relaxed)) check();
}

}  // namespace taut
