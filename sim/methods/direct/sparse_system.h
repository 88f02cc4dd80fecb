// A square sparse system of equations with an unsymmetric matrix, solved by LU with pivoting.
#pragma once

#include <Eigen/SparseLU>
#include <cstdint>
#include <span>
#include <vector>

namespace taut::direct {

/// Entries are added in any order, several to one place. As long as the places of two assemblies
/// are the same, in the same order, the second costs no search. The unknowns come in groups (a
/// particle, a body), which are ordered by Cuthill and McKee's reverse breadth-first search. Where
/// that makes a narrow band, as for chains, the band is factorised with row pivoting; else Eigen's
/// supernodal LU does it.
class SparseSystem {
 public:
  /// Starts a matrix of as many rows as `groups` has numbers; each is the group of an unknown.
  /// Takes the places of the entries anew.
  void reshape(std::span<const std::uint32_t> groups);
  /// Starts an assembly.
  void clear();
  void add(std::size_t row, std::size_t column, double value) {
    if (recording_) {
      places_.push_back({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column)});
      recorded_.push_back(value);
      return;
    }
    values_[slots_[next_++]] += value;
  }
  /// Adds nine entries: those of `block` from a row and a column on.
  void add(std::size_t row, std::size_t column, const Eigen::Matrix3d& block) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        add(row + i, column + j, block(static_cast<int>(i), static_cast<int>(j)));
      }
    }
  }
  /// Factorises what was added since clear(). False where the matrix is singular to rounding.
  bool factorise();
  /// Replaces the right side by the solution.
  void solve(std::span<double> right);

  std::size_t size() const { return groups_.size(); }
  std::uint64_t factorisations() const { return factorisations_; }

 private:
  struct Place {
    std::uint32_t row = 0, column = 0;
  };
  void analyse();
  void order();
  bool factorise_band();
  void solve_band();

  std::vector<std::uint32_t> groups_;
  bool recording_ = true;
  std::vector<Place> places_;
  std::vector<double> recorded_;
  std::vector<std::size_t> slots_;  // of values_, by the order of add()
  std::size_t next_ = 0;
  std::vector<std::uint32_t> position_;  // of an unknown, in the order of elimination
  std::vector<double> values_;           // of the band by columns, or of the sparse matrix
  // Of the band: entries below the diagonal, of a column, and above it in the factors.
  std::size_t below_ = 0, height_ = 0, above_ = 0;
  std::vector<std::uint32_t> pivots_;
  std::vector<double> work_;  // a right side between zeros
  bool banded_ = true;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_;
  std::uint64_t factorisations_ = 0;
};

}  // namespace taut::direct
