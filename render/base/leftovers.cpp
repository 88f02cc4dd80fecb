#include "render/base/leftovers.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <csignal>
#include <cstring>
#include <ctime>

namespace taut::render {
namespace {

constexpr int kFiles = 256, kChildren = 64;

/// The state counts up: three steps from one free state to the next, so that a reader sees whether
/// the name is still the one that it copied.
struct Slot {
  static constexpr unsigned kFree = 0, kFilling = 1, kFilled = 2, kStates = 3;
  std::atomic<unsigned> state = kFree;
  char name[PATH_MAX] = {};
};

Slot files[kFiles];
std::atomic<pid_t> children[kChildren];
static_assert(std::atomic<pid_t>::is_always_lock_free &&
              std::atomic<unsigned>::is_always_lock_free);

void remove(const Slot& slot) {
  const unsigned before = slot.state.load();
  if (before % Slot::kStates != Slot::kFilled) return;
  char name[PATH_MAX];
  std::memcpy(name, slot.name, sizeof name);
  std::atomic_thread_fence(std::memory_order_acquire);
  if (slot.state.load() == before) unlink(name);
}

/// A killed child may still write for a moment; one that the system holds up is left after a tenth
/// of a second.
void end(pid_t child) {
  kill(child, SIGKILL);
  constexpr timespec kPause{0, 1'000'000};
  for (int i = 0; i < 100 && waitpid(child, nullptr, WNOHANG) == 0; ++i) {
    nanosleep(&kPause, nullptr);
  }
}

}  // namespace

UnfinishedFile::UnfinishedFile(const std::filesystem::path& file) {
  const std::string& name = file.native();
  if (name.size() >= PATH_MAX) return;
  for (int i = 0; i < kFiles; ++i) {
    unsigned state = files[i].state.load();
    if (state % Slot::kStates != Slot::kFree) continue;
    if (!files[i].state.compare_exchange_strong(state, state + Slot::kFilling)) continue;
    std::memcpy(files[i].name, name.c_str(), name.size() + 1);
    files[i].state.store(state + Slot::kFilled);
    slot_ = i;
    return;
  }
}

void UnfinishedFile::finish() noexcept {
  if (slot_ >= 0) ++files[slot_].state;
  slot_ = -1;
}

RunningChild::RunningChild(pid_t child) {
  for (int i = 0; i < kChildren; ++i) {
    pid_t none = 0;
    if (!children[i].compare_exchange_strong(none, child)) continue;
    slot_ = i;
    return;
  }
}

void RunningChild::finish() noexcept {
  if (slot_ >= 0) children[slot_] = 0;
  slot_ = -1;
}

void remove_leftovers() noexcept {
  for (const std::atomic<pid_t>& child : children) {
    if (const pid_t id = child.load()) end(id);
  }
  for (const Slot& slot : files) remove(slot);
}

}  // namespace taut::render
