#include "sim/methods/direct/sincos.h"

#include <gtest/gtest.h>

#include <cmath>

namespace taut::direct {
namespace {

/// Rounding of the cosine and sine given, of those of the first angle and of the sum.
constexpr double kRounding = 1e-15;

TEST(SinCos, AnglesOfUnitVectorsAreThoseOfTheLibrary) {
  for (int i = -4000; i <= 4000; ++i) {
    const double angle = i * (3.14159 / 4000);
    EXPECT_NEAR(angle_of(std::cos(angle), std::sin(angle)), angle, kRounding);
  }
}

TEST(SinCos, AnglesAlongAxes) {
  EXPECT_EQ(angle_of(1, 0), 0);
  EXPECT_NEAR(angle_of(0, 1), std::atan2(1, 0), kRounding);
  EXPECT_NEAR(angle_of(0, -1), std::atan2(-1, 0), kRounding);
  EXPECT_NEAR(angle_of(-1, 0), std::atan2(0, -1), kRounding);
}

}  // namespace
}  // namespace taut::direct
