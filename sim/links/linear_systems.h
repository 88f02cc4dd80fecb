// Linear systems: small dense ones, by Eigen; ones of which many entries are zero; and sparse ones.
// Eigen's decompositions take long to compile: they are compiled here, once.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

/// Square systems of which many entries are zero.
///
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

/// L D L^T of a sparse symmetric positive definite matrix, whose pattern stays while its values
/// change.
///
/// Rows are eliminated in an order of small fill (minimum degree), row by row (Davis, ACM
/// Transactions on Mathematical Software 31, 2005, Algorithm 849). The work of a chain of
/// neighbours, or a tree of chains, is linear in its length. Allocates in analyse() alone.
class SparseLdlt {
 public:
  struct Coupling {
    std::uint32_t row = 0, other = 0;
  };

  /// The pattern: the rows' diagonal and these couplings, each named once.
  void analyse(std::size_t rows, std::span<const Coupling> couplings);

  /// Factors the matrix of `values`: the rows' diagonal, then the couplings as they were named. A
  /// row whose pivot vanishes, as it is a combination of others, is left out: its unknown is zero.
  void factor(const double* values);
  /// Solves for a right side; both in the order in which the rows were given. They may be one.
  void solve(const double* right, double* x);

  /// Rows that the last factor() left out.
  std::size_t dependent() const { return dependent_; }
  /// Entries below the diagonal of L, and what factor() multiplies.
  std::size_t entries() const { return row_of_.size(); }
  double products() const { return products_; }

 private:
  struct Known {  // a coupling of a row with one that is eliminated before it
    std::uint32_t column = 0, value = 0;
  };

  std::size_t rows_ = 0, dependent_ = 0;
  double products_ = 0;
  std::vector<std::uint32_t> order_;     // the row that is eliminated as the k-th
  std::vector<std::uint32_t> known_of_;  // per eliminated row: where its couplings begin
  std::vector<Known> known_;
  std::vector<std::uint32_t> reach_of_;   // per eliminated row: where the columns of its L begin
  std::vector<std::uint32_t> reach_;      // rising
  std::vector<std::uint32_t> column_of_;  // per column: where its entries begin
  std::vector<std::uint32_t> row_of_;     // of each entry
  std::vector<double> entry_, inverse_;   // of L, and of D
  std::vector<std::uint32_t> filled_;     // per column: entries that are known so far
  std::vector<double> scratch_;
};

}  // namespace taut
