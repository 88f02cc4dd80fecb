#include "scenes/model/sandbox.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <new>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "sim/motion/stop.h"

namespace taut::scenes {
namespace {

// The system calls allowed to a process that reads untrusted input.

#if defined(__x86_64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kMachine = 0;
#endif

constexpr std::initializer_list<std::uint32_t> kAllowed = {
    // memory
    SYS_mmap, SYS_munmap, SYS_mremap, SYS_mprotect, SYS_madvise, SYS_brk,
    // what is open
    SYS_read, SYS_readv, SYS_write, SYS_writev, SYS_close, SYS_lseek, SYS_fstat,
    // locks and time
    SYS_futex, SYS_sched_yield, SYS_clock_gettime, SYS_clock_nanosleep, SYS_gettimeofday,
    // questions about itself
    SYS_getpid, SYS_gettid, SYS_getrandom, SYS_getrusage, SYS_sched_getaffinity, SYS_sysinfo,
    SYS_uname, SYS_rt_sigaction, SYS_rt_sigprocmask, SYS_rt_sigreturn, SYS_sigaltstack,
#ifdef TAUT_SANITIZED  // its checks of types ask a pipe whether memory can be read
    SYS_pipe2,
#endif
    // its end
    SYS_exit, SYS_exit_group};

/// The lower half of an argument; all flags are in it.
constexpr std::uint32_t argument(int number) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args)) +
         8 * static_cast<std::uint32_t>(number);
}

class Filter {
 public:
  Filter() {
    load(offsetof(seccomp_data, arch));
    add(BPF_JMP | BPF_JEQ | BPF_K, kMachine, 1, 0);
    end(SECCOMP_RET_KILL_PROCESS);
    load(offsetof(seccomp_data, nr));
  }

  void allow(std::uint32_t call) {
    add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1);
    end(SECCOMP_RET_ALLOW);
  }

  /// Only where the bits of `mask` of the argument are those of `value`.
  void allow(std::uint32_t call, int number, std::uint32_t mask, std::uint32_t value) {
    add(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 5);
    load(argument(number));
    add(BPF_ALU | BPF_AND | BPF_K, mask);
    add(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1);
    end(SECCOMP_RET_ALLOW);
    end(SECCOMP_RET_KILL_PROCESS);
  }

  /// False where the kernel takes none.
  bool install() {
    end(SECCOMP_RET_KILL_PROCESS);
    sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
  }

 private:
  void add(int code, std::uint32_t value, std::uint8_t if_true = 0, std::uint8_t if_false = 0) {
    code_.push_back({static_cast<std::uint16_t>(code), if_true, if_false, value});
  }
  void load(std::size_t offset) {
    add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
  }
  void end(std::uint32_t action) { add(BPF_RET | BPF_K, action); }

  std::vector<sock_filter> code_;
};

/// From now on, until its end, this process can have memory, read and write what is open, and end;
/// any other call kills it: none opens a file or a connection, asks for a file's existence, makes,
/// changes or removes one, starts a process, or reaches another one. Does nothing where the kernel
/// has no such filters or refuses them, and on machines other than x86-64 and 64-bit ARM.
void allow_few_calls() {
  if (kMachine == 0) return;
  Filter filter;
  for (const std::uint32_t call : kAllowed) filter.allow(call);
  filter.allow(SYS_tgkill, 0, ~0u, static_cast<std::uint32_t>(getpid()));  // abort()
  filter.install();
}

constexpr int kReplyFile = 3;  // after the standard streams
constexpr int kNoMemory = 2;   // exit codes of the child
constexpr int kCrashed = 3;
constexpr int kOutOfMemory = 4;

int no_memory_code = kNoMemory;  // with which the child ends where it gets no memory

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Bytes of address space that the process has now; 0 where the system does not tell.
rlim_t address_space() {
  const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  char text[64] = {};
  const ssize_t count = file < 0 ? 0 : read(file, text, sizeof text - 1);
  if (file >= 0) close(file);
  unsigned long long pages = 0;
  if (count <= 0 || std::sscanf(text, "%llu", &pages) != 1) return 0;
  return static_cast<rlim_t>(pages) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t soft, rlim_t hard) {
  rlimit now{};
  getrlimit(static_cast<__rlimit_resource_t>(resource), &now);
  const rlimit least{std::min(soft, now.rlim_cur), std::min(hard, now.rlim_max)};
  setrlimit(static_cast<__rlimit_resource_t>(resource), &least);
}

void take_away(const SandboxLimits& limits) {
  const double whole = std::floor(limits.cpu_time);
  const itimerval timer{
      {}, {static_cast<time_t>(whole), static_cast<suseconds_t>(1e6 * (limits.cpu_time - whole))}};
  setitimer(ITIMER_PROF, &timer, nullptr);
  // The child can stop a timer where the kernel has no filters of calls, but not raise a limit.
  const auto seconds = static_cast<rlim_t>(whole) + 1;
  limit(RLIMIT_CPU, seconds, seconds + 1);
  limit(RLIMIT_FSIZE, 0, 0);
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_NPROC, 0, 0);
  if (const rlim_t now = address_space(); now > 0) {
    rlimit before{};
    getrlimit(RLIMIT_AS, &before);
    if (before.rlim_cur < now + limits.memory) no_memory_code = kOutOfMemory;
    limit(RLIMIT_AS, now + limits.memory, now + limits.memory);
  }
#ifndef TAUT_SANITIZED         // its checks of types ask a pipe whether memory can be read
  limit(RLIMIT_NOFILE, 0, 0);  // nothing can be opened where the kernel has no filters, too
#endif
  allow_few_calls();
}

/// The child has the handlers of its parent, which may do more than end it.
void end_by_faults() {
  for (const int signal :
       {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPROF, SIGXCPU, SIGSYS, SIGINT, SIGTERM}) {
    std::signal(signal, SIG_DFL);
  }
  std::signal(SIGXFSZ, SIG_IGN);  // what is said on standard error may go to a file
  std::set_new_handler([] { _exit(no_memory_code); });
}

[[noreturn]] void be_child(const SandboxLimits& limits, int reply_file, pid_t parent,
                           const std::function<std::string()>& work) noexcept {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kCrashed);  // it ended before that
  dup2(reply_file, kReplyFile);
  close(STDIN_FILENO);
  close(STDOUT_FILENO);
  close_range(kReplyFile + 1, ~0u, 0);
  end_by_faults();
  take_away(limits);
  std::string reply;
  try {
    reply = work();
  } catch (const std::bad_alloc&) {
    _exit(no_memory_code);
  }
  for (std::size_t done = 0; done < reply.size();) {
    const ssize_t n = write(kReplyFile, reply.data() + done, reply.size() - done);
    if (n < 0 && errno != EINTR) _exit(kCrashed);
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  _exit(0);
}

/// All that comes until the child closes its end; how it ended where it takes or says too much.
std::optional<SandboxResult::End> read_reply(int file, const SandboxLimits& limits,
                                             std::string& reply) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(limits.wall_time);
  char block[1 << 16];
  while (reply.size() <= limits.reply) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) return SandboxResult::End::no_time;
    check_stop();
    pollfd ready{file, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 100))) <= 0) continue;
    const ssize_t n = read(file, block, sizeof block);
    if (n == 0) return {};
    if (n > 0) reply.append(block, static_cast<std::size_t>(n));
  }
  return SandboxResult::End::too_long;
}

/// How a child ended that took `cpu_time` (s) of the time that `limits` allow.
SandboxResult::End end_of(int status, double cpu_time, const SandboxLimits& limits) {
  using End = SandboxResult::End;
  switch (status) {
    case 0:
      return End::replied;
    case kNoMemory:
      return End::no_memory;
    case kOutOfMemory:
      return End::out_of_memory;
    case 128 + SIGPROF:
    case 128 + SIGXCPU:
      return End::no_time;
    case 128 + SIGKILL:  // the hard limit of CPU time, or the system has no memory left
      return cpu_time < limits.cpu_time ? End::out_of_memory : End::no_time;
    case 128 + SIGSYS:
      return End::forbidden;
    default:
      return End::crashed;
  }
}

/// A child, killed at the latest by the end of this.
class Forked {
 public:
  explicit Forked(pid_t id) : id_(id) {}
  ~Forked() {
    if (id_ > 0) end();
  }
  Forked(const Forked&) = delete;
  Forked& operator=(const Forked&) = delete;

  /// The child's exit code, or 128 + its signal, and the CPU time (s) that it took.
  std::pair<int, double> end() {
    kill(id_, SIGKILL);
    return *ended(0);
  }

  /// The same of one that ends by itself soon.
  std::optional<std::pair<int, double>> end_soon() {
    constexpr timespec kPause{0, 1'000'000};
    for (int i = 0; i < 1000; ++i) {
      if (auto status = ended(WNOHANG)) return status;
      nanosleep(&kPause, nullptr);
    }
    return {};
  }

 private:
  std::optional<std::pair<int, double>> ended(int options) {
    int status = 0;
    rusage used{};
    pid_t found = 0;
    do {
      found = wait4(id_, &status, options, &used);
    } while (found < 0 && errno == EINTR);
    if (found == 0) return {};
    id_ = 0;
    if (found < 0) return {{0, 0.0}};  // nobody may wait for children here: the reply alone tells
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return {{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
             seconds(used.ru_utime) + seconds(used.ru_stime)}};
  }

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

SandboxResult run_in_sandbox(const SandboxLimits& limits,
                             const std::function<std::string()>& work) {
  Pipe pipe;
  const pid_t parent = getpid();
  const pid_t id = fork();
  if (id < 0) fail("cannot start a process");
  if (id == 0) be_child(limits, pipe.ends[1], parent, work);
  Forked child(id);
  close(pipe.ends[1]);
  pipe.ends[1] = -1;
  SandboxResult result;
  auto beyond = read_reply(pipe.ends[0], limits, result.reply);
  check_stop();  // which may be why it ended
  auto ended = beyond ? std::nullopt : child.end_soon();
  if (!ended) {  // it says too much, or works on
    ended = child.end();
    if (!beyond) beyond = SandboxResult::End::no_time;
  }
  result.status = ended->first;
  result.end = beyond ? *beyond : end_of(ended->first, ended->second, limits);
  return result;
}

}  // namespace taut::scenes
