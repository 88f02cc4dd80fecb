// Work that ends within limits whatever it does: in a copy of this process that is killed there.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace taut::render {

struct Bounds {
  double cpu_time = 0;     // s, more than 0
  std::size_t memory = 0;  // bytes, beyond what the process has at the fork
};

/// Sends a text to the process that waits.
using Say = std::function<void(std::string_view text)>;

struct Bounded {
  enum class End { done, no_time, no_memory, failed };
  End end = End::failed;
  std::string said;  // until then
};

/// Runs `work` in a copy of this process and gathers what it says until it returns or meets a
/// limit. `work` says by itself what went wrong: an exception that leaves it ends as `failed`,
/// std::bad_alloc as `no_memory`. Of threads only the caller's is in the copy. It dies with the
/// thread that waits. Throws std::system_error where there can be no copy, and Interrupted, the
/// copy killed.
Bounded run_bounded(const Bounds& bounds, const std::function<void(const Say& say)>& work);

/// CPU time (s) of this process, all its threads together; of a copy since the fork.
double process_seconds();
/// CPU time (s) of all processes that this one started and that have ended.
double children_seconds();

}  // namespace taut::render
