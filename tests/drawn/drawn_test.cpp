// Scenes that nobody chose keep every promise with every method; one that does not is made small
// and kept beside this file.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <map>

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

/// What came of the scenes, in one line.
struct Sums {
  int scenes = 0, refused = 0, runs = 0, diverged = 0, compared = 0, broken = 0;
};

Sums check_seeds(unsigned first, unsigned count) {
  Sums sums;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const std::string scene = scene_text(seed);
    const Verdict verdict = check_promises(scene);
    ++sums.scenes;
    sums.refused += verdict.refusal.empty() ? 0 : 1;
    sums.runs += verdict.runs;
    sums.diverged += verdict.diverged;
    sums.compared += verdict.compared;
    sums.broken += static_cast<int>(verdict.broken.size());
    for (const Broken& broken : verdict.broken) tell(seed, scene, broken);
  }
  return sums;
}

void expect_worth(const Sums& sums) {
  std::cout << fmt::format(
      "{} scenes, {} refused, {} runs, {} diverged with a message, {} compared with the truth, {} "
      "promises broken\n",
      sums.scenes, sums.refused, sums.runs, sums.diverged, sums.compared, sums.broken);
  EXPECT_LT(sums.refused, sums.scenes / 4);
  EXPECT_GT(sums.compared, sums.scenes / 4);
}

TEST(Drawn, ScenesKeepEveryPromise) {
  expect_worth(check_seeds(0, 15));
}

// TAUT_SEED and TAUT_SCENES in the environment choose others.
TEST(LongDrawn, TenThousandScenesKeepEveryPromise) {
  const char* first = std::getenv("TAUT_SEED");
  const char* count = std::getenv("TAUT_SCENES");
  expect_worth(check_seeds(first ? static_cast<unsigned>(std::atoi(first)) : 0,
                           count ? static_cast<unsigned>(std::atoi(count)) : 10'000));
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
