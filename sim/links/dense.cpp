#include "sim/links/dense.h"

#include "sim/motion/stop.h"

namespace taut {

void LeastSquares::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
}

Eigen::VectorXd LeastSquares::solve(const Eigen::VectorXd& right) const {
  return decomposed_.solve(right);
}

// By columns: a solver of many at once would be compiled, too.
Eigen::MatrixXd LeastSquares::solve(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd x(decomposed_.cols(), right.cols());
  for (Eigen::Index k = 0; k < right.cols(); ++k) {
    check_stop();
    x.col(k) = solve(Eigen::VectorXd(right.col(k)));
  }
  return x;
}

void LinearSystem::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
  const auto pivots = decomposed_.matrixLU().diagonal().cwiseAbs();
  is_singular_ = pivots.size() > 0 && !(pivots.minCoeff() > kDependent * pivots.maxCoeff());
  if (is_singular_) dependent_.compute(matrix);
}

void LinearSystem::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) const {
  if (is_singular_) {
    x = dependent_.solve(right);
  } else {
    x = decomposed_.solve(right);
  }
}

}  // namespace taut
