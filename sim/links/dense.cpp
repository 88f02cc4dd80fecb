#include "sim/links/dense.h"

namespace taut {

void LeastSquares::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
}

Eigen::VectorXd LeastSquares::solve(const Eigen::VectorXd& right) const {
  return decomposed_.solve(right);
}

Eigen::MatrixXd LeastSquares::solve(const Eigen::MatrixXd& right) const {
  return decomposed_.solve(right);
}

void LinearSystem::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
}

void LinearSystem::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) const {
  x = decomposed_.solve(right);
}

}  // namespace taut
