#include "render/program/watch.h"

#include <chrono>
#include <thread>

#include "render/base/interrupt.h"
#include "render/program/program.h"

namespace taut::program {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kBetween{100};  // looks

/// When each was written last; editors may take a file away for a moment.
std::vector<fs::file_time_type> times_of(const std::vector<fs::path>& files) {
  std::vector<fs::file_time_type> times;
  std::error_code error;
  for (const fs::path& file : files) times.push_back(fs::last_write_time(file, error));
  return times;
}

}  // namespace

int watch(const std::vector<fs::path>& files, const Common& common,
          const std::function<int()>& work) {
  for (;;) {
    const auto seen = times_of(files);
    const int code = guarded(common, work);
    if (code == kInterrupted || code == kTerminated) return kDone;
    while (times_of(files) == seen) {
      if (render::pending_interrupt()) return kDone;
      std::this_thread::sleep_for(kBetween);
    }
  }
}

}  // namespace taut::program
