// Square systems of which many entries are zero.
#pragma once

#include <vector>

#include "sim/links/dense.h"

namespace taut {

/// Gaussian elimination by threshold pivoting (Duff, Erisman, Reid: Direct Methods for Sparse
/// Matrices): rows with few entries go first, on their diagonals where these are no smaller than a
/// tenth of what stands in the row and the column; what is left is dense and has pivots of its own.
/// Entries should be near one. Allocates nothing for a system of a size and pattern that it has
/// had.
class ThresholdElimination {
 public:
  void compute(const Eigen::MatrixXd& matrix);
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& x);

 private:
  struct Step {
    Eigen::Index pivot = 0;
    std::size_t rows_end = 0, columns_end = 0;  // of its own in rows_ and columns_
  };
  bool takes(Eigen::Index pivot);

  Eigen::MatrixXd work_, rest_matrix_;  // factors below pivots, rows beside them
  Eigen::VectorXd rest_right_, rest_x_;
  std::vector<Step> steps_;
  std::vector<Eigen::Index> rows_, columns_;  // of the entries beside each pivot
  std::vector<Eigen::Index> rest_;            // rows without a step
  LinearSystem rest_system_;
};

}  // namespace taut
