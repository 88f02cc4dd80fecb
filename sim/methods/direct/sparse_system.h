// A square sparse system of equations with an unsymmetric matrix, solved by LU with pivoting.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/methods/direct/system/links.h"

namespace taut::direct {

/// Where an entry of a matrix is.
struct MatrixPlace {
  std::uint32_t row = 0, column = 0;
};

/// LU of a band, as of chains: unknowns are ordered by Cuthill and McKee's reverse breadth-first
/// search.
class BandLu {
 public:
  /// Each unknown belongs to a group. Entries may share a place.
  void analyse(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places);
  /// Entries beside the diagonal, on either side.
  std::size_t width() const { return below_; }
  /// False where the matrix is singular to rounding.
  bool factorise(std::span<const double> values);
  void solve(std::span<double> right);

 private:
  void order(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places);

  std::vector<std::uint32_t> position_;  // of an unknown, in the order of elimination
  std::vector<std::size_t> slots_;       // of entries, in band_
  std::vector<double> band_;             // by columns
  // Entries below the diagonal, of a column, and above it in the factors.
  std::size_t below_ = 0, height_ = 0, above_ = 0;
  std::vector<std::uint32_t> pivots_;
  std::vector<double> work_;  // a right side between zeros
};

/// Multifrontal LU (Duff and Reid 1983), as of nets. Groups are eliminated in the order of least
/// degree. Groups that have about the same neighbours make a front: a dense matrix of the unknowns
/// that are eliminated there and of those that they touch. A front takes its own entries and what
/// its children have left, eliminates its own unknowns, and leaves the rest to its parent. Rows are
/// swapped among those that are complete. A column without a pivot that is large enough waits for
/// the parent.
class FrontLu {
 public:
  /// Each unknown belongs to a group. Entries may share a place.
  void analyse(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places);
  /// False where the matrix is singular to rounding.
  bool factorise(std::span<const double> values);
  void solve(std::span<double> right);

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  /// Ranges are of the arrays named.
  struct Front {
    std::uint32_t parent = kNone, children = 0;
    std::uint32_t own = 0, own_end = 0;      // own_: unknowns that are eliminated here
    std::uint32_t rest = 0, rest_end = 0;    // rest_: unknowns that these touch
    std::uint32_t entry = 0, entry_end = 0;  // entries_
    // Of the last factorisation: pivots, and rows and columns in all.
    std::uint32_t pivots = 0, size = 0;
    std::size_t factors = 0, index = 0;  // where they begin in factors_, rows_ and columns_
    std::uint32_t own_size() const { return own_end - own; }
    std::uint32_t rest_size() const { return rest_end - rest; }
  };
  /// A value (of values_) and its place in a front in which no column waits.
  struct Entry {
    std::uint32_t value = 0, at = 0;
  };

  std::size_t size_ = 0;
  std::vector<Front> fronts_;  // children before their parents
  std::vector<std::uint32_t> own_, rest_;
  std::vector<std::uint32_t> in_parent_;  // of each of rest_: its place in the parent
  std::vector<Entry> entries_;
  // The last factorisation: of each front the columns of its lower factor, then those of its upper
  // one, and the equations and unknowns of its rows and columns.
  Array factors_;
  std::vector<std::uint32_t> rows_, columns_;
  /// What fronts have left for their parents, the newest last.
  struct Left {
    std::uint32_t front = 0, waiting = 0;  // waiting: columns without a pivot
    std::size_t values = 0, index = 0;     // in left_values_, left_rows_ and left_columns_
  };
  std::vector<Left> left_;
  std::vector<double> left_values_;
  std::vector<std::uint32_t> left_rows_, left_columns_;
  std::vector<std::uint32_t> where_;  // in a front, of what a child has left
  Array work_;
  std::vector<double> pivot_values_;
};

/// Entries are added in any order, several to one place. As long as the places of two assemblies
/// are the same, in the same order, the second costs no search. The unknowns come in groups: a
/// particle with its links and contacts, a body.
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
      values_.push_back(value);
    } else {
      values_[next_++] = value;
    }
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
  std::vector<std::uint32_t> groups_;
  bool recording_ = true;
  std::vector<MatrixPlace> places_;
  std::vector<double> values_;  // in the order of add()
  std::size_t next_ = 0;
  bool banded_ = true;
  BandLu band_;
  FrontLu fronts_;
  std::uint64_t factorisations_ = 0;
};

}  // namespace taut::direct
