#include <gtest/gtest.h>

#include <cmath>

#include "sim/methods/direct/system/links.h"

namespace taut::direct {
namespace {

TEST(SinCos, IsThatOfTheLibraryToItsRounding) {
  constexpr double kRounding = 4e-16;
  for (int i = -4000; i <= 4000; ++i) {
    const double angle = i * 0.0123;
    const SinCos found = sine_and_cosine(angle);
    const double rounding = kRounding * (1 + std::abs(angle));
    EXPECT_NEAR(found.sine, std::sin(angle), rounding) << angle;
    EXPECT_NEAR(found.cosine, std::cos(angle), rounding) << angle;
  }
}

TEST(SinCos, IsExactAlongAxes) {
  EXPECT_EQ(sine_and_cosine(0).sine, 0);
  EXPECT_EQ(sine_and_cosine(0).cosine, 1);
}

}  // namespace
}  // namespace taut::direct
