// The error that `direct` is asked for is the one that it delivers, and the one that it tells, on
// scenes that nobody chose.
#include <gtest/gtest.h>

#include "tests/bench/promise/score.h"

namespace taut::promise {
namespace {

/// Shares of the length.
constexpr double kTolerances[] = {1e-1, 3e-2, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
constexpr double kCap = 60;  // s of CPU time for a reference or a run

struct Count {
  int cells = 0, within_one = 0, within_three = 0, told = 0;
};

Count run_seeds(unsigned seeds) {
  Count count;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    const Drawn drawn = draw(seed);
    const Reference reference = make_reference(drawn, kCap);
    if (!reference.usable()) continue;
    for (const double tolerance : kTolerances) {
      Score result = score(drawn, reference, {"direct", {}}, tolerance, 1, kCap);
      add_estimate(result, drawn, reference, {"direct", {}}, 1);
      ++count.cells;
      count.within_one += result.error <= 1 ? 1 : 0;
      count.within_three += result.error <= 3 ? 1 : 0;
      count.told += near(result) ? 1 : 0;
    }
  }
  return count;
}

// Four scenes of each kind.
TEST(Promise, DrawnScenesDeliverTheirToleranceAndTellTheirError) {
  const Count count = run_seeds(4 * kKinds.size());
  EXPECT_GT(count.cells, 100);
  EXPECT_GE(count.within_one, 0.95 * count.cells);
  EXPECT_EQ(count.within_three, count.cells);
  EXPECT_GE(count.told, 0.9 * count.cells);
}

// A thousand. Where neighbouring motions part quickly, one cell in a thousand exceeds three
// tolerances: errors are set without knowledge of how they will grow.
TEST(LongPromise, AThousandDrawnScenesDeliverTheirToleranceAndTellTheirError) {
  const Count count = run_seeds(1000);
  EXPECT_GT(count.cells, 5000);
  EXPECT_GE(count.within_one, 0.95 * count.cells);
  EXPECT_GE(count.within_three, 0.998 * count.cells);
  EXPECT_GE(count.told, 0.9 * count.cells);
}

}  // namespace
}  // namespace taut::promise
