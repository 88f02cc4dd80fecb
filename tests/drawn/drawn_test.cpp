// Scenes that nobody chose keep every promise with every method; one that does not is made small
// and kept beside this file.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <mutex>
#include <thread>

#include "tests/drawn/promises.h"
#include "tests/drawn/scene_text.h"
#include "tests/drawn/shrink.h"
#include "tests/support/folder.h"

namespace taut::drawn {
namespace {

namespace fs = std::filesystem;

const fs::path kKept = TAUT_SOURCE_DIR "/tests/drawn/kept";

std::string small(const std::string& scene, const Broken& broken) {
  return shrunk(scene, [&](const std::string& smaller) {
    return std::ranges::any_of(check_promises(smaller, broken.method).broken, [&](const Broken& b) {
      return b.promise == broken.promise && b.method == broken.method;
    });
  });
}

/// With TAUT_KEEP in the environment, scenes that fail are made small and added to the kept ones.
void tell(unsigned seed, const std::string& scene, const Broken& broken) {
  std::string text;
  if (std::getenv("TAUT_KEEP")) {
    text = fmt::format("# {} of {} by seed {}: {}\n{}", broken.promise, broken.method, seed,
                       broken.what, small(scene, broken));
    const std::string name = fmt::format("{}_{}_{}.toml", broken.promise, broken.method, seed);
    std::ofstream(kKept / name) << text;
  }
  ADD_FAILURE() << "seed " << seed << ", " << broken.method << ": " << broken.promise << ": "
                << broken.what << '\n'
                << text;
}

/// Checks scenes on all processors. Their outcome is one line of the output.
void check_seeds(unsigned first, unsigned count) {
  Verdict sum;
  unsigned refused = 0;
  std::atomic<unsigned> next = first;
  std::mutex mutex;
  const auto work = [&] {
    for (unsigned seed = 0; (seed = next++) < first + count;) {
      const std::string scene = scene_text(seed);
      const Verdict verdict = check_promises(scene);
      const std::lock_guard lock(mutex);
      refused += verdict.refusal.empty() ? 0 : 1;
      sum.runs += verdict.runs;
      sum.ended += verdict.ended;
      sum.diverged += verdict.diverged;
      sum.compared += verdict.compared;
      sum.told += verdict.told;
      sum.missed += verdict.missed;
      if (verdict.missed > 0) std::cout << "seed " << seed << ": beyond 3 tolerances\n";
      for (const Broken& broken : verdict.broken) tell(seed, scene, broken);
      std::ranges::move(verdict.broken, std::back_inserter(sum.broken));
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned i = std::thread::hardware_concurrency(); i > 0; --i) threads.emplace_back(work);
  }
  std::cout << fmt::format(
      "{} scenes, {} refused; {} runs: {} to the end, {} ended by a message; {} compared with the "
      "truth, {} beyond 3 tolerances as their estimates tell, {} otherwise; {} promises broken\n",
      count, refused, sum.runs, sum.ended, sum.diverged, sum.compared, sum.told, sum.missed,
      sum.broken.size());
  EXPECT_LE(refused, count / 4);
  EXPECT_GT(sum.ended + sum.diverged, sum.runs * 3 / 4);
  EXPECT_GE(sum.compared, static_cast<int>(count) / 4);
  EXPECT_LE(sum.told, sum.compared / 20);
  EXPECT_LE(sum.missed, 1 + sum.compared / 1000);
}

TEST(Drawn, ScenesKeepEveryPromise) {
  check_seeds(0, 250);
}

// TAUT_SEED and TAUT_SCENES in the environment choose others.
TEST(LongDrawn, TenThousandScenesKeepEveryPromise) {
  const char* first = std::getenv("TAUT_SEED");
  const char* count = std::getenv("TAUT_SCENES");
  check_seeds(first ? static_cast<unsigned>(std::atoi(first)) : 0,
              count ? static_cast<unsigned>(std::atoi(count)) : 10'000);
}

TEST(Drawn, KeptScenesKeepEveryPromise) {
  for (const auto& file : fs::directory_iterator(kKept)) {
    if (file.path().extension() != ".toml") continue;
    const Verdict verdict = check_promises(read_file(file.path()));
    EXPECT_EQ(verdict.refusal, "");
    for (const Broken& broken : verdict.broken) {
      ADD_FAILURE() << file.path() << ": " << broken.method << ": " << broken.promise << ": "
                    << broken.what;
    }
  }
}

TEST(Drawn, AFailureIsMadeSmall) {
  const std::string scene = scene_text(3);
  const auto fails = [](const std::string& text) {
    return text.find("[connectors.c0]") != text.npos && text.find("fps") != text.npos;
  };
  ASSERT_TRUE(fails(scene));
  const std::string left = shrunk(scene, fails);
  EXPECT_TRUE(fails(left));
  EXPECT_EQ(std::ranges::count(left, '\n'), 2) << left;
}

}  // namespace
}  // namespace taut::drawn
