// Whatever untrusted work does in its child process, the caller gets an answer and keeps what it
// has.
#include "scenes/model/sandbox.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/support/filters.h"
#include "tests/support/folder.h"

namespace taut::sandbox_test {
namespace {

using End = scenes::SandboxResult::End;

constexpr scenes::SandboxLimits kLimits = {
    .memory = 256u << 20, .reply = 1u << 20, .cpu_time = 1, .wall_time = 60};

scenes::SandboxResult run(const std::function<std::string()>& work,
                          const scenes::SandboxLimits& limits = kLimits) {
  return scenes::run_in_sandbox(limits, work);
}

std::size_t open_files() {
  const auto files = std::filesystem::directory_iterator("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

TEST(Sandbox, WorkIsAnswered) {
  for (const std::size_t size : {0, 1, 1 << 20}) {
    const std::string answer(size, 'a');
    const scenes::SandboxResult result = run([&] { return answer; });
    EXPECT_EQ(result.end, End::replied);
    EXPECT_EQ(result.reply, answer);
  }
}

TEST(Sandbox, NothingOfTheChildStays) {
  const std::size_t files = open_files();
  std::string kept = "before";
  for (int i = 0; i < 20; ++i) {
    run([&] { return kept = "after"; });
    run([&]() -> std::string { std::abort(); });
  }
  EXPECT_EQ(kept, "before");
  EXPECT_EQ(open_files(), files);
  EXPECT_EQ(wait(nullptr), -1);  // no child is left
}

TEST(Sandbox, ACrashIsNamedByItsSignal) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE}) {
    const scenes::SandboxResult result = run([&] { return raise(signal), std::string(); });
    EXPECT_EQ(result.end, End::crashed);
    EXPECT_EQ(result.status, 128 + signal);
  }
  const scenes::SandboxResult result = run([]() -> std::string { _exit(7); });
  EXPECT_EQ(result.end, End::crashed);
  EXPECT_EQ(result.status, 7);
}

TEST(Sandbox, WorkWithoutEndIsEnded) {
  const auto loop = []() -> std::string {
    for (volatile bool goes_on = true; goes_on;) {
    }
    return {};
  };
  scenes::SandboxLimits limits = kLimits;
  limits.cpu_time = 0.1;
  const scenes::SandboxResult ended = run(loop, limits);
  EXPECT_EQ(ended.end, End::no_time);
  EXPECT_EQ(ended.status, 128 + SIGPROF);  // not by whole seconds
  const auto sleep = []() -> std::string {
    for (;;) std::this_thread::sleep_for(std::chrono::seconds(1));
  };
  limits.wall_time = 0.1;
  EXPECT_EQ(run(sleep, limits).end, End::no_time);
  const auto silent = [&]() -> std::string {
    close(3);
    return sleep();
  };
  EXPECT_EQ(run(silent).end, End::no_time);
}

TEST(Sandbox, MemoryEndsWhereTheLimitIs) {
#ifdef TAUT_SANITIZED
  GTEST_SKIP() << "a sanitizer's allocator ends the process itself";
#endif
  const auto take = [](std::size_t bytes) {
    return [=] {
      std::vector<char> memory(bytes, 'x');
      return std::string(1, memory.back());
    };
  };
  EXPECT_EQ(run(take(kLimits.memory / 2)).end, End::replied);
  EXPECT_EQ(run(take(4 * kLimits.memory)).end, End::no_memory);
  EXPECT_EQ(run([] { return std::string(kLimits.reply + 1, 'x'); }).end, End::too_long);
  // In a process that may take less than the limit.
  const auto ends_by_own_limit = [&] {
    const rlimit own{1u << 30, 1u << 30};
    setrlimit(RLIMIT_AS, &own);
    const scenes::SandboxLimits more{8ul << 30, 1u << 20, 10, 10};
    return run(take(4ul << 30), more).end == End::out_of_memory;
  };
  EXPECT_EXIT(exit(ends_by_own_limit() ? 7 : 8), testing::ExitedWithCode(7), "");
}

TEST(Sandbox, WhatItNeedsNotIsForbidden) {
  if (!has_filters()) GTEST_SKIP() << "no filters of system calls here";
  const Folder folder;
  const std::string kept = folder.write("kept", "as it was").string();
  const std::string made = (folder.path() / "made").string();
  const pid_t parent = getpid();
  const std::pair<const char*, std::function<void()>> attempts[] = {
      {"connects", [] { socket(AF_UNIX, SOCK_STREAM, 0); }},
      {"makes a file", [&] { open(made.c_str(), O_RDWR | O_CREAT, 0600); }},
      {"makes a file without a name",
       [&] { open(folder.path().c_str(), O_TMPFILE | O_WRONLY, 0600); }},
      {"reads a file", [&] { open(kept.c_str(), O_RDONLY); }},
      {"reads a file by its folder", [&] { openat(AT_FDCWD, kept.c_str(), O_RDONLY); }},
      {"asks for a file", [&] { access(kept.c_str(), R_OK); }},
      {"asks what a file is", [&] { (void)std::filesystem::file_size(kept); }},
      {"follows a link", [&] { (void)std::filesystem::read_symlink("/proc/self/exe"); }},
      {"writes into a file", [&] { open(kept.c_str(), O_WRONLY); }},
      {"empties a file", [&] { open(kept.c_str(), O_RDONLY | O_TRUNC); }},
      {"removes a file", [&] { unlink(kept.c_str()); }},
      {"renames a file", [&] { rename(kept.c_str(), made.c_str()); }},
      {"makes a folder", [&] { std::filesystem::create_directory(made); }},
      {"starts a process", [] { fork(); }},
      {"becomes a program", [] { execl("/bin/true", "true", nullptr); }},
      {"ends another process", [&] { kill(parent, SIGTERM); }},
      {"takes its limits back", [] {
         const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
         setrlimit(RLIMIT_CPU, &none);
       }}};
  for (const auto& [what, attempt] : attempts) {
    EXPECT_EQ(run([&attempt = attempt] { return attempt(), std::string(); }).end, End::forbidden)
        << what;
  }
  EXPECT_EQ(read_file(kept), "as it was");
  EXPECT_FALSE(std::filesystem::exists(made));
}

TEST(Sandbox, NothingIsOpenedWithoutFiltersToo) {
#ifdef TAUT_SANITIZED
  GTEST_SKIP() << "its checks of types open a pipe";
#endif
  const scenes::SandboxResult result = run([] {
    rlimit files{};
    getrlimit(RLIMIT_NOFILE, &files);
    return std::to_string(files.rlim_cur) + ' ' + std::to_string(files.rlim_max);
  });
  if (result.end == End::forbidden) GTEST_SKIP() << "the filters forbid the question";
  EXPECT_EQ(result.reply, "0 0");
}

TEST(Sandbox, ThereMayBeThreadsAndIgnoredChildren) {
  const auto previous = signal(SIGCHLD, SIG_IGN);
  std::vector<std::thread> threads;
  std::vector<std::string> replies(8);
  for (std::size_t i = 0; i < replies.size(); ++i) {
    threads.emplace_back([&, i] {
      for (int round = 0; round < 20; ++round) {
        const std::string text(1000 + 100 * i, static_cast<char>('a' + i));  // allocates
        replies[i] = run([&] { return text + text; }).reply;
        if (replies[i] != text + text) break;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  signal(SIGCHLD, previous);
  for (std::size_t i = 0; i < replies.size(); ++i) {
    EXPECT_EQ(replies[i], std::string(2000 + 200 * i, static_cast<char>('a' + i)));
  }
}

}  // namespace
}  // namespace taut::sandbox_test
