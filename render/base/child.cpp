#include "render/base/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
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
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>
#include <system_error>
#include <thread>

#include "render/base/interrupt.h"

namespace taut::render {
namespace {

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("child", MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail(errno, "cannot make a memory file");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }

  void put(const std::string& text) {
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = write(descriptor_, text.data() + done, text.size() - done);
      if (n < 0 && errno != EINTR) fail(errno, "cannot write to a memory file");
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    lseek(descriptor_, 0, SEEK_SET);
  }

  std::string get() const {
    std::string text(static_cast<std::size_t>(lseek(descriptor_, 0, SEEK_END)), '\0');
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n =
          pread(descriptor_, text.data() + done, text.size() - done, static_cast<off_t>(done));
      if (n == 0) break;
      if (n < 0 && errno != EINTR) fail(errno, "cannot read a memory file");
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    return text;
  }

 private:
  int descriptor_;
};

/// The child's work between the fork and the program: only calls that are safe there, as other
/// threads may have held any lock. Ends with errno in `failure` where there is no such program.
[[noreturn]] void become(char* const* arguments, const char* folder, const int (&files)[3],
                         pid_t parent, int failure, const ChildLimits& limits) {
  // The kernel ends the child with the thread that made it; a parent that is gone by now never
  // will.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const rlimit cpu{limits.cpu_time, limits.cpu_time + 1}, output{limits.output, limits.output};
  if (limits.cpu_time > 0) setrlimit(RLIMIT_CPU, &cpu);
  if (limits.output > 0) {
    setrlimit(RLIMIT_FSIZE, &output);
    std::signal(SIGXFSZ, SIG_DFL);
  }
  for (int i = 0; i < 3; ++i) {
    if (files[i] != i) dup2(files[i], i);
  }
  if (!*folder || chdir(folder) == 0) execvp(arguments[0], arguments);
  const int error = errno;
  [[maybe_unused]] const ssize_t told = write(failure, &error, sizeof error);
  _exit(127);
}

/// A child process; it outlives neither this nor the thread that made it, however that ends.
class Child {
 public:
  Child(const std::vector<std::string>& arguments, const std::filesystem::path& folder, int in,
        int out, int err, const ChildLimits& limits) {
    std::vector<char*> argv;
    for (const std::string& argument : arguments)
      argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    int failure[2];  // closed by the program's start
    if (pipe2(failure, O_CLOEXEC) != 0) fail(errno, "cannot make a pipe");
    const pid_t parent = getpid();
    id_ = fork();
    const int fork_error = errno;
    if (id_ == 0) become(argv.data(), folder.c_str(), {in, out, err}, parent, failure[1], limits);
    close(failure[1]);
    int error = id_ < 0 ? fork_error : 0;
    if (id_ > 0) {
      while (read(failure[0], &error, sizeof error) < 0 && errno == EINTR) {
      }
    }
    close(failure[0]);
    if (error == 0) {
      running_.emplace(id_);
      return;
    }
    if (id_ > 0) waitpid(id_, &status_, 0);
    fail(error, "cannot start " + arguments[0]);
  }
  ~Child() {
    if (ended_) return;
    kill();
    running_.reset();
    waitpid(id_, &status_, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  bool ended() {
    siginfo_t info{};
    const auto id = static_cast<id_t>(id_);
    if (waitid(P_PID, id, &info, WEXITED | WNOHANG | WNOWAIT) != 0) {
      if (errno == EINTR) return false;
      fail(errno, "cannot wait for a child process");
    }
    if (info.si_pid != id_) return false;
    running_.reset();
    wait4(id_, &status_, 0, &used_);
    return ended_ = true;
  }
  void kill() const { ::kill(id_, SIGKILL); }
  /// CPU time of all its threads, s.
  double cpu_time() const {
    clockid_t clock;
    timespec time{};
    if (clock_getcpuclockid(id_, &clock) == 0) clock_gettime(clock, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
  }
  /// True where one of its threads would work, were a processor free, or waits for a disk.
  bool wants_to_work() const {
    std::error_code gone;
    const auto tasks = "/proc/" + std::to_string(id_) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
      std::ifstream file(task.path() / "stat");
      const std::string stat((std::istreambuf_iterator<char>(file)), {});
      const std::size_t name_end = stat.rfind(") ");  // its name may hold anything
      if (name_end == std::string::npos) continue;
      const char state = stat[name_end + 2];
      if (state == 'R' || state == 'D') return true;
    }
    return false;
  }
  /// CPU time once it has ended, with the children that it waited for, s.
  double cpu_time_used() const {
    const auto seconds = [](const timeval& time) {
      return double(time.tv_sec) + 1e-6 * double(time.tv_usec);
    };
    return seconds(used_.ru_utime) + seconds(used_.ru_stime);
  }
  int status() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_); }

 private:
  pid_t id_ = 0;
  std::optional<RunningChild> running_;
  int status_ = 0;
  rusage used_{};
  bool ended_ = false;
};

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments, const std::string& input,
                      const ChildLimits& limits, const std::filesystem::path& folder) {
  using Clock = std::chrono::steady_clock;
  MemoryFile in, out, err;
  in.put(input);
  Child child(arguments, folder, in.descriptor(), out.descriptor(), err.descriptor(), limits);
  std::string blocked;
  auto last_work = Clock::now();
  double work = 0;
  for (auto pause = std::chrono::milliseconds(1); !child.ended();) {
    stop_if_interrupted();
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::milliseconds(20));
    if (const double now = child.cpu_time(); now > work) {
      work = now;
      last_work = Clock::now();
    } else if (blocked.empty() && Clock::now() - last_work > limits.patience &&
               !child.wants_to_work()) {
      blocked = arguments[0] + " did nothing for too long and was killed\n";
      child.kill();
    }
  }
  return {child.status(), child.cpu_time_used(), out.get(), blocked + err.get()};
}

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
