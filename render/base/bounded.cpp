#include "render/base/bounded.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <new>
#include <system_error>

#include "render/base/interrupt.h"

namespace taut::render {
namespace {

constexpr int kNoMemory = 2;  // exit codes of the copy
constexpr int kFailed = 3;

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Bytes of address space that the process has; 0 where the system does not say.
rlim_t address_space() {
  std::FILE* file = std::fopen("/proc/self/statm", "re");
  unsigned long long pages = 0;
  if (file) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

void limit(__rlimit_resource_t resource, rlim_t most) {
  rlimit now{};
  getrlimit(resource, &now);
  const rlimit least{std::min(most, now.rlim_max), now.rlim_max};
  setrlimit(resource, &least);
}

void say_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(file, text.data(), text.size());
    if (n < 0 && errno != EINTR) _exit(kFailed);  // nobody reads
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
}

[[noreturn]] void be_copy(const Bounds& bounds, int file, pid_t parent,
                          const std::function<void(const Say&)>& work) noexcept {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kFailed);
  std::signal(SIGPROF, SIG_DFL);
  std::set_new_handler(nullptr);
  limit(RLIMIT_CORE, 0);
  if (const rlim_t now = address_space(); now > 0) limit(RLIMIT_AS, now + bounds.memory);
  const double whole = std::floor(bounds.cpu_time);
  const itimerval timer{
      {}, {static_cast<time_t>(whole), static_cast<suseconds_t>(1e6 * (bounds.cpu_time - whole))}};
  setitimer(ITIMER_PROF, &timer, nullptr);
  try {
    work([file](std::string_view text) { say_all(file, text); });
  } catch (const std::bad_alloc&) {
    _exit(kNoMemory);
  } catch (...) {
    _exit(kFailed);
  }
  _exit(0);
}

/// A copy, killed at the latest by the end of this.
class Copy {
 public:
  explicit Copy(pid_t id) : id_(id) {}
  ~Copy() {
    if (id_ <= 0) return;
    kill(id_, SIGKILL);
    end();
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;

  /// Waits until it ends.
  Bounded::End end() {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = 0;
    if (WIFSIGNALED(status)) {
      return WTERMSIG(status) == SIGPROF ? Bounded::End::no_time : Bounded::End::failed;
    }
    switch (WEXITSTATUS(status)) {
      case 0:
        return Bounded::End::done;
      case kNoMemory:
        return Bounded::End::no_memory;
      default:
        return Bounded::End::failed;
    }
  }

 private:
  pid_t id_;
};

struct Pipe {
  int ends[2] = {-1, -1};
  Pipe() {
    if (pipe2(ends, O_CLOEXEC) != 0) fail("cannot make a pipe");
  }
  ~Pipe() {
    for (const int end : ends) {
      if (end >= 0) close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
};

}  // namespace

Bounded run_bounded(const Bounds& bounds, const std::function<void(const Say&)>& work) {
  Pipe pipe;
  std::fflush(nullptr);  // what is in a buffer would be written twice
  const pid_t parent = getpid();
  const pid_t id = fork();
  if (id < 0) fail("cannot start a process");
  if (id == 0) be_copy(bounds, pipe.ends[1], parent, work);
  Copy copy(id);
  close(pipe.ends[1]);
  pipe.ends[1] = -1;
  Bounded result;
  char block[1 << 16];
  for (;;) {
    stop_if_interrupted();
    constexpr int kLook = 100;  // ms, between two looks for an interrupt
    pollfd ready{pipe.ends[0], POLLIN, 0};
    if (poll(&ready, 1, kLook) <= 0) continue;
    const ssize_t n = read(pipe.ends[0], block, sizeof block);
    if (n == 0) break;
    if (n > 0) result.said.append(block, static_cast<std::size_t>(n));
  }
  result.end = copy.end();
  return result;
}

double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double children_seconds() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace taut::render
