#include "render/base/interrupt.h"

#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <ctime>
#include <string_view>

namespace taut::render {
namespace {

constexpr suseconds_t kPatience = 700'000;  // microseconds
constexpr double kTogether = 0.1;           // s: signals that come so soon are one, as timeout(1)
                                            // sends it to the process and to its group

std::atomic<int> pending = 0;
std::atomic<double> noted_at = 0;  // s
std::atomic<pid_t> owner = 0;
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<double>::is_always_lock_free);

const char* name_of(int number) {
  return number == SIGINT ? "interrupted" : "terminated";
}

double now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

void say(std::string_view text) {
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
}

/// Without destructors; safe in a signal handler.
[[noreturn]] void end_now(int number) {
  remove_leftovers();
  say("taut: ");
  say(name_of(number));
  say("\n");
  _exit(128 + number);
}

void note(int number) {
  // A child that has not become another program yet has nothing of its own to remove.
  if (getpid() != owner) _exit(128 + number);
  const int error = errno;
  int none = 0;
  if (pending.compare_exchange_strong(none, number)) {
    noted_at = now();
    const itimerval timer{{}, {0, kPatience}};
    setitimer(ITIMER_REAL, &timer, nullptr);
  } else if (now() - noted_at > kTogether) {
    end_now(number);
  }
  errno = error;
}

void end_work_that_goes_on(int) {
  if (getpid() == owner && pending) end_now(pending);
}

}  // namespace

const char* Interrupted::what() const noexcept {
  return name_of(signal);
}

void catch_interrupts() {
  owner = getpid();
  struct sigaction action {};
  action.sa_handler = end_work_that_goes_on;
  sigaction(SIGALRM, &action, nullptr);
  action.sa_handler = note;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

int pending_interrupt() {
  return pending;
}

void stop_if_interrupted() {
  if (const int number = pending.load(std::memory_order_relaxed)) throw Interrupted(number);
}

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
