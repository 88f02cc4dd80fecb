// Small dense systems, by Eigen. Its decompositions take long to compile: they are compiled here,
// once.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>

namespace taut {

/// Solutions of least squares and, where those are many, of least norm.
class LeastSquares {
 public:
  /// `threshold`: the share of the largest pivot below which one counts as zero.
  explicit LeastSquares(double threshold = 1e-12) { decomposed_.setThreshold(threshold); }

  void compute(const Eigen::MatrixXd& matrix);
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposed_;
};

/// Solutions of square systems; of one that is singular, as rows that depend on each other make it,
/// the solution of least norm among those that come closest. Allocates nothing for a regular system
/// of a size that it has had.
class LinearSystem {
 public:
  void compute(const Eigen::MatrixXd& matrix);
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) const;

 private:
  /// The share of the largest pivot below which one is rounding, or what a stage of an integrator
  /// leaves of a dependence: the square of how far it is off.
  static constexpr double kDependent = 1e-10;

  Eigen::PartialPivLU<Eigen::MatrixXd> decomposed_;
  bool is_singular_ = false;
  LeastSquares dependent_{kDependent};
};

}  // namespace taut
