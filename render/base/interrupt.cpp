#include "render/base/interrupt.h"

#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <string_view>

#include "render/base/leftovers.h"

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

}  // namespace taut::render
