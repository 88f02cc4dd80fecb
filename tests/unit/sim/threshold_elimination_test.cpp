#include <gtest/gtest.h>

#include <random>

#include "sim/links/linear_systems.h"

namespace taut::threshold_elimination_test {
namespace {

/// A system as pulleys make it: [A, -C; -C^t, -S] with A positive definite, each pulley between two
/// neighbours, and S as `inertia`.
Eigen::MatrixXd pulleys(Eigen::Index spans, double inertia, double friction) {
  const Eigen::Index size = 2 * spans - 1;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index s = 0; s < spans; ++s) {
    for (Eigen::Index t = 0; t < spans; ++t) matrix(s, t) = (s == t ? 0.3 : 0) + 0.1;
  }
  for (Eigen::Index p = 0; p + 1 < spans; ++p) {
    const Eigen::Index row = spans + p;
    matrix(p, row) = 1;
    matrix(p + 1, row) = -1;
    matrix(row, p) = 1 + friction;
    matrix(row, p + 1) = -1;
    matrix(row, row) = -inertia;
  }
  return matrix;
}

void expect_solved(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd known = Eigen::VectorXd::LinSpaced(matrix.rows(), -1, 2);
  ThresholdElimination system;
  Eigen::VectorXd x;
  for (int twice = 0; twice < 2; ++twice) {  // nothing of the first is left over
    system.compute(matrix);
    system.solve(matrix * known, x);
    EXPECT_LT((x - known).norm(), 1e-11 * known.norm());
  }
}

TEST(ThresholdElimination, SolvesWhatPulleysMake) {
  for (const double inertia : {0.0, 1e-9, 0.5, 100.0}) {
    for (const double friction : {0.0, 0.4}) expect_solved(pulleys(17, inertia, friction));
  }
}

TEST(ThresholdElimination, SolvesFullAndEmptyOnes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const Eigen::Index size : {1, 2, 7, 30}) {
    for (const double share : {0.1, 0.5, 1.0}) {
      Eigen::MatrixXd matrix(size, size);
      for (double& entry : matrix.reshaped()) {
        entry = any(random) < 2 * share - 1 ? any(random) : 0;
      }
      matrix.diagonal().array() += 3;
      expect_solved(matrix);
      // The same with its rows turned over: no diagonal is a pivot.
      expect_solved(matrix.colwise().reverse());
    }
  }
  ThresholdElimination system;
  Eigen::VectorXd x;
  system.compute(Eigen::MatrixXd(0, 0));
  system.solve(Eigen::VectorXd(0), x);
  EXPECT_EQ(x.size(), 0);
}

}  // namespace
}  // namespace taut::threshold_elimination_test
