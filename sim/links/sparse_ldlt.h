// L D L^T of a sparse symmetric positive definite matrix, whose pattern stays while its values
// change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace taut {

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
