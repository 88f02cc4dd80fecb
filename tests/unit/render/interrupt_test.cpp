// Signals: what ends by itself, what is ended, and that nothing unfinished stays.
#include "render/base/interrupt.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "render/base/atomic_file.h"
#include "sim/motion/stop.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut::interrupt_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

/// Work that never looks for signals, in a process of its own, once it has made `ready`.
class Stuck {
 public:
  Stuck(const fs::path& ready, const std::function<void()>& work) {
    id_ = fork();
    if (id_ == 0) {
      render::catch_interrupts();
      try {
        work();
        std::ofstream(ready) << "ready";
        for (;;) pause();
      } catch (...) {
        _exit(1);
      }
    }
    comes_true([&] { return fs::exists(ready); });
  }
  ~Stuck() {
    if (id_ > 0) ::kill(id_, SIGKILL);
    wait();
  }
  Stuck(const Stuck&) = delete;
  Stuck& operator=(const Stuck&) = delete;

  void send(int signal) const { ::kill(id_, signal); }
  /// Its exit code, or 128 and the signal that killed it.
  int wait() {
    if (id_ <= 0) return -1;
    int status = 0;
    waitpid(std::exchange(id_, 0), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t id_ = 0;
};

std::size_t files_in(const fs::path& folder) {
  return std::size_t(std::distance(fs::directory_iterator(folder), {}));
}

TEST(Interrupt, EndsWorkThatDoesNotLookAndLeavesNothingUnfinished) {
  for (const auto& [signal, code] : {std::pair(SIGINT, 130), {SIGTERM, 143}}) {
    const Folder folder;
    Stuck stuck(folder.path() / "ready", [&] {
      static render::AtomicFile csv(folder.path() / "t.csv");
      csv.write("half");
      static render::AtomicFile whole(folder.path() / "whole");
      whole.commit();
      static const render::PartFile video(folder.path() / "v.mp4");
    });
    ASSERT_EQ(files_in(folder.path()), 4u);
    const auto start = std::chrono::steady_clock::now();
    stuck.send(signal);
    EXPECT_EQ(stuck.wait(), code);
    EXPECT_GT(std::chrono::steady_clock::now() - start, milliseconds(600))
        << "time to end by itself";
    EXPECT_TRUE(fs::exists(folder.path() / "whole"));
    EXPECT_EQ(files_in(folder.path()), 2u);
  }
}

TEST(Interrupt, ASecondSignalEndsItAtOnce) {
  const Folder folder;
  Stuck stuck(folder.path() / "ready",
              [&] { static const render::PartFile video(folder.path() / "v.mp4"); });
  stuck.send(SIGTERM);
  std::this_thread::sleep_for(milliseconds(150));
  stuck.send(SIGTERM);
  EXPECT_EQ(stuck.wait(), 143);
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(Leftovers, NamesAreTakenAndLeftInAnyOrder) {
  const Folder folder;
  std::vector<std::unique_ptr<render::UnfinishedFile>> all;
  std::vector<fs::path> names;
  for (int i = 0; i < 40; ++i) {
    names.push_back(folder.write("f" + std::to_string(i), "x"));
    all.push_back(std::make_unique<render::UnfinishedFile>(names.back()));
  }
  for (std::size_t i = 0; i < all.size(); i += 3) all[i].reset();
  render::remove_leftovers();
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(fs::exists(names[i]), i % 3 == 0) << i;
}

}  // namespace
}  // namespace taut::interrupt_test
