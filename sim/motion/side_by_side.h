// Work that is done on all cores at once, with the same results on any number of them.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "sim/motion/stop.h"

namespace taut {

/// Calls `work(i)` for every i below `count`, several at a time, in the order of i. Throws the
/// exception of the smallest i that threw, so that it does not depend on the number of cores.
template <class Work>
void side_by_side(std::size_t count, Work work) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr failure;
  std::size_t failed = count;
  std::mutex mutex;
  const auto go = [&] {
    std::size_t i = 0;
    try {
      for (i = next++; i < count; i = next++) {
        check_stop();
        work(i);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (i < failed) {
        failed = i;
        failure = std::current_exception();
      }
      next = count;
    }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
    try {
      for (std::size_t k = 1; k < std::min(cores, count); ++k) others.emplace_back(go);
    } catch (const std::system_error&) {  // no more threads are to be had: fewer do the work
    }
    go();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace taut
