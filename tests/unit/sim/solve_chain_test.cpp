// The tensions of straight chains, which are sums of weights.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sim/methods/direct/system/links.h"

namespace taut::direct {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

/// The tensions of a chain that hangs straight from a hold, its points of `masses` (kg); a point of
/// infinite mass is held, too.
std::vector<double> tensions(const std::vector<double>& masses) {
  const std::size_t n = masses.size();
  std::vector<double> scale(n), diagonal_first(n), diagonal_second(n), off_diagonal(n),
      sine_squared(n), right(n), x(n), scratch(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const double before = i > 0 ? 1 / masses[i - 1] : 0, after = 1 / masses[i];
    scale[i] = std::sqrt(2 / (before + after));
    diagonal_first[i] = scale[i] * scale[i] * before;
    diagonal_second[i] = scale[i] * scale[i] * after;
  }
  for (std::size_t i = 0; i + 1 < n; ++i) off_diagonal[i] = scale[i] * scale[i + 1] / masses[i];
  right[0] = scale[0] * kGravity;
  if (std::isinf(masses.back())) right[n - 1] -= scale[n - 1] * kGravity;
  solve_chain(n, diagonal_first.data(), diagonal_second.data(), off_diagonal.data(),
              sine_squared.data(), right.data(), x.data(), scratch.data());
  for (std::size_t i = 0; i < n; ++i) x[i] *= scale[i];
  return x;
}

// The matrix is singular but for a part in 10^12; every row rounds a few times.
TEST(SolveChain, KeepsItsDigitsUnderAnyLoad) {
  for (const std::size_t n : {1, 2, 3, 4, 1000}) {
    for (const double load : {1.0, 1e6, 1e9}) {
      std::vector<double> masses(n, 5e-5);
      masses.back() *= load;
      const std::vector<double> found = tensions(masses);
      double below = 0;
      for (std::size_t i = n; i-- > 0;) {
        below += masses[i];
        const double rounding = 8 * static_cast<double>(n) * std::numeric_limits<double>::epsilon();
        EXPECT_NEAR(found[i], kGravity * below, rounding * kGravity * below) << n << ", " << i;
      }
    }
  }
}

// Any tension may be added to all links.
TEST(SolveChain, TakesTheMiddleForSlackBetweenTwoHolds) {
  EXPECT_EQ(tensions({1, 1, 1, INFINITY}),
            (std::vector<double>{2 * kGravity, kGravity, 0, -kGravity}));
}

}  // namespace
}  // namespace taut::direct
