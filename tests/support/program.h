// Runs a program and gathers what it says.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace taut {

struct ProgramResult {
  int code = 0;  // exit code; 128 + the signal that killed it, as shells say it
  std::string output, messages;
  double cpu_seconds = 0;  // of the program and of those that it waited for
};

/// Waits until something is so, however busy the machine is; false after an hour.
inline bool comes_true(const std::function<bool()>& is_so) {
  constexpr auto kPause = std::chrono::milliseconds(2);
  for (std::chrono::milliseconds waited{}; !is_so(); waited += kPause) {
    if (waited > std::chrono::hours(1)) return false;
    std::this_thread::sleep_for(kPause);
  }
  return true;
}

/// A child process with pipes from its standard output and error.
class Child {
 public:
  /// `prepare` runs in the child before the program does. `folder` is where it starts.
  Child(std::vector<std::string> command, const std::filesystem::path& folder,
        const std::function<void()>& prepare = {}) {
    int out[2], err[2];
    if (pipe2(out, O_CLOEXEC) != 0 || pipe2(err, O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe");
    }
    std::vector<char*> words;
    for (std::string& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    id_ = fork();
    if (id_ == 0) {
      dup2(out[1], STDOUT_FILENO);
      dup2(err[1], STDERR_FILENO);
      if (chdir(folder.c_str()) != 0) _exit(126);
      if (prepare) prepare();
      execvp(words[0], words.data());
      _exit(127);
    }
    close(out[1]);
    close(err[1]);
    out_ = out[0];
    err_ = err[0];
  }
  ~Child() {
    if (id_ > 0) {
      ::kill(id_, SIGKILL);
      wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t id() const { return id_; }

  /// The standard error up to this text, which the program writes while it runs; all of it if the
  /// program ends before.
  std::string messages_until(std::string_view text) {
    char c = 0;
    while (outcome_.messages.find(text) == std::string::npos && read(err_, &c, 1) == 1)
      outcome_.messages += c;
    return outcome_.messages;
  }

  /// Waits until something is so, or the program has ended; true where it is so.
  bool runs_until(const std::function<bool()>& is_so) const {
    comes_true([&] { return is_so() || ended(); });
    return is_so();
  }
  bool ended() const {
    siginfo_t info{};
    waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT);
    return info.si_pid == id_;
  }
  /// CPU time of the program and of those that it started and that have ended, s.
  double cpu_seconds() const {
    std::ifstream file("/proc/" + std::to_string(id_) + "/stat");
    std::string text((std::istreambuf_iterator<char>(file)), {});
    text.erase(0, text.rfind(')') + 1);  // its name may hold anything
    std::istringstream words(text);
    constexpr int kBefore = 11;
    std::string word;
    for (int i = 0; i < kBefore; ++i) words >> word;
    double ticks = 0;
    for (int i = 0; i < 4; ++i) {
      double some = 0;
      if (words >> some) ticks += some;
    }
    return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
  }

  /// Reads until the program ends; kills it after `limit` of CPU time, or where it does nothing for
  /// ten minutes.
  ProgramResult wait(std::chrono::seconds limit = std::chrono::seconds(120)) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::minutes kIdle(10);
    const double most = std::chrono::duration<double>(limit).count();
    double work = 0;
    auto last_work = Clock::now();
    pollfd pipes[2] = {{out_, POLLIN, 0}, {err_, POLLIN, 0}};
    std::string* texts[2] = {&outcome_.output, &outcome_.messages};
    while (pipes[0].fd >= 0 || pipes[1].fd >= 0) {
      poll(pipes, 2, 100);
      for (int i = 0; i < 2; ++i) {
        if (pipes[i].fd < 0 || pipes[i].revents == 0) continue;
        char block[1 << 16];
        const ssize_t count = read(pipes[i].fd, block, sizeof block);
        if (count > 0) {
          texts[i]->append(block, static_cast<std::size_t>(count));
        } else {
          pipes[i].fd = -1;
        }
      }
      if (const double now = cpu_seconds(); now > work) {
        work = now;
        last_work = Clock::now();
      }
      if (work > most || Clock::now() - last_work > kIdle) {
        ::kill(id_, SIGKILL);
        outcome_.messages += "\n[killed by the test: it ran too long]";
        break;
      }
    }
    close(out_);
    close(err_);
    int status = 0;
    rusage usage{};
    wait4(id_, &status, 0, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      outcome_.cpu_seconds +=
          static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    id_ = -1;
    outcome_.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return outcome_;
  }

 private:
  pid_t id_ = -1;
  int out_ = -1, err_ = -1;
  ProgramResult outcome_;
};

/// Runs taut itself.
inline ProgramResult run_taut(std::vector<std::string> arguments,
                              const std::filesystem::path& folder = TAUT_SOURCE_DIR,
                              const std::function<void()>& prepare = {}) {
  arguments.insert(arguments.begin(), TAUT_PROGRAM);
  return Child(std::move(arguments), folder, prepare).wait();
}

/// Runs taut and ends it by `signal` once `file` is longer than `size`: again where it was done
/// before that.
inline ProgramResult stopped_once_written(std::vector<std::string> arguments,
                                          const std::filesystem::path& folder,
                                          const std::filesystem::path& file, std::uintmax_t size,
                                          int signal) {
  arguments.insert(arguments.begin(), TAUT_PROGRAM);
  const auto is_long = [&] {
    std::error_code none;
    const std::uintmax_t now = std::filesystem::file_size(file, none);
    return !none && now > size;
  };
  for (;;) {
    Child child(arguments, folder);
    child.runs_until(is_long);
    ::kill(child.id(), signal);
    ProgramResult outcome = child.wait();
    if (outcome.code != 0) return outcome;
    std::filesystem::remove(file);
  }
}

}  // namespace taut
