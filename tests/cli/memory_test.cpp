// The peak memory of `taut render`, by the kernel: it does not grow with the clip, and stays below
// the estimate of `taut check`.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

class Memory : public testing::Test {
 protected:
  /// The most that `taut render` had at once, in bytes.
  double peak(std::vector<std::string> arguments, int threads = 1) const {
    arguments.insert(arguments.begin(),
                     {TAUT_PROGRAM, "render", fmt::format("--threads={}", threads), "--no-video",
                      "--quiet", "--out=out"});
    std::vector<char*> words;
    for (std::string& word : arguments) words.push_back(word.data());
    words.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(folder_.path().c_str()) == 0 && freopen("/dev/null", "w", stdout))
        execv(TAUT_PROGRAM, words.data());
      _exit(127);
    }
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    EXPECT_EQ(status, 0);
    return 1024.0 * double(usage.ru_maxrss);
  }
  double said(const std::string& scene, int threads = 1, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"check", scene, "--threads", std::to_string(threads), "--json"});
    const ProgramResult checked = run_taut(more, folder_.path());
    return nlohmann::json::parse(checked.output).at("render").at("memory_bytes");
  }

  Folder folder_;
};

using LongMemory = Memory;

TEST_F(LongMemory, DoesNotGrowWithTheClip) {
  constexpr int kParticles = 2000, kFew = 15, kMany = 150;
  folder_.write("rope.toml", fmt::format(R"(
duration = 5
fps = 30
[method]
name = "impulse"
step = 1e-3
[connectors.rope]
length = 1
mass = 0.1
particles = {}
from = {{ fixed = [0, 1, 0] }}
to = {{ fixed = [0.5, 1, 0] }}
[stage]
shutter = 0.5
camera = [{{ t = 0, position = [0, 0.9, 3], target = [0, 0.8, 0] }}]
)",
                                         kParticles));
  const auto until = [&](int frames) {
    return peak({"rope.toml", "--size=16x10", fmt::format("--frames=0-{}", frames - 1)});
  };
  const double few = until(kFew), many = until(kMany);
  // A shutter of half a frame shows many states; one alone of each frame, kept, would be this.
  const double states = double(kMany - kFew) * kParticles * 3 * sizeof(double);
  EXPECT_LT(many - few, states / 2);
  EXPECT_LT(many, said("rope.toml"));
}

/// A thousand cords, and a stage behind an open lens.
TEST_F(LongMemory, LargeScenesAreDrawnByTwoThreadsInHalfAGigabyte) {
  constexpr int kThreads = 2;
  struct Case {
    std::string name, frames, size;
  };
  for (const auto& [name, frames, size] :
       {Case{"bead_curtain", "--frames=42-43", "--set=size=[1920,1080]"},
        Case{"nunchaku", "--frames=12-13", "--set=size=[1280,720]"}}) {
    const std::string scene = fmt::format("{}/scenes/{}.toml", TAUT_SOURCE_DIR, name);
    const double most = peak({scene, frames, size}, kThreads), told = said(scene, kThreads, {size});
    EXPECT_LT(most, 5e8) << name;
    EXPECT_LT(most, told) << name;
    EXPECT_GT(most, told / 2) << name;
  }
}

}  // namespace
}  // namespace taut
