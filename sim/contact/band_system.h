// Linear systems whose matrix has a narrow band.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace taut::contact {

/// A x = b by Gaussian elimination with row pivoting, where A(i, j) is zero beyond `half` places
/// from the diagonal: linear time in the size. Columns are scaled to their largest entry, so that
/// unknowns may differ by any number of orders. An unknown that nothing determines is zero.
class BandSystem {
 public:
  /// All entries are zero afterwards.
  void clear(std::size_t size, std::size_t half);
  std::size_t size() const { return size_; }
  /// For |i - j| <= half.
  double& at(std::size_t i, std::size_t j) { return band_[j * height_ + 2 * half_ + i - j]; }

  /// Once all entries are set.
  void factor();
  /// In place.
  void solve(std::span<double> x) const;

 private:
  std::size_t size_ = 0, half_ = 0, height_ = 0;
  std::vector<double> band_;  // by columns: `half` rows of fill, then those of A from the top
  std::vector<double> scale_;
  std::vector<std::size_t> pivot_;
};

}  // namespace taut::contact
