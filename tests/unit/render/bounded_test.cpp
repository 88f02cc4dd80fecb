// Work in a copy of the process: what it said is kept, however it ends.
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "render/base/child.h"

namespace taut::bounded_test {
namespace {

using render::Bounded;
using render::Say;

constexpr std::size_t kMemory = 1'000'000'000;

TEST(BoundedWork, SaysWhatItFound) {
  int here = 0;
  const Bounded result = render::run_bounded({10, kMemory}, [&](const Say& say) {
    here = 1;
    say("one ");
    say(std::string(100'000, 'x'));
  });
  EXPECT_EQ(result.end, Bounded::End::done);
  EXPECT_EQ(result.said, "one " + std::string(100'000, 'x'));
  EXPECT_EQ(here, 0) << "it changes nothing here";
}

TEST(BoundedWork, EndsWhereItTakesTooLong) {
  const Bounded result = render::run_bounded({0.05, kMemory}, [](const Say& say) {
    say("begun");
    for (double some = 0; some >= 0;) some = render::process_seconds();
  });
  EXPECT_EQ(result.end, Bounded::End::no_time);
  EXPECT_EQ(result.said, "begun");
}

TEST(BoundedWork, EndsWhereItTakesTooMuchMemory) {
#ifdef TAUT_SANITIZED
  GTEST_SKIP() << "a sanitizer's allocator ends the process";
#endif
  const Bounded result = render::run_bounded({10, kMemory}, [](const Say& say) {
    const std::vector<char> much(4 * kMemory);
    say(much.empty() ? "none" : "some");
  });
  EXPECT_EQ(result.end, Bounded::End::no_memory);
  EXPECT_EQ(result.said, "");
}

TEST(BoundedWork, KeepsAnExceptionToItself) {
  const Bounded result =
      render::run_bounded({10, kMemory}, [](const Say&) { throw std::runtime_error("no"); });
  EXPECT_EQ(result.end, Bounded::End::failed);
}

}  // namespace
}  // namespace taut::bounded_test
