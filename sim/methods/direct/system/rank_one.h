// Solves with a band matrix and a product of one vector with itself on top of it.
#pragma once

#include <vector>

#include "sim/methods/direct/system/band_ldlt.h"

namespace taut::direct {

/// (A + s g g^T) x = r by the factors of A: Sherman and Morrison, Annals of Mathematical Statistics
/// 21, 1950. Without a g it is A alone.
template <class Scalar, std::size_t kHalf>
class RankOne {
 public:
  using Matrix = BandLdlt<Scalar, kHalf>;

  /// `matrix` is factored; `slope` is g, or empty.
  void factor(const Matrix& matrix, const std::vector<double>& slope, Scalar s) {
    slope_ = slope;
    if (slope.empty()) return;
    solved_.resize(slope.size());
    for (std::size_t i = 0; i < slope.size(); ++i) solved_[i] = slope[i] * Scalar{1};
    matrix.solve(solved_.data());
    share_ = s * inverse(Scalar{1} + s * along(solved_.data()));
  }

  void solve(const Matrix& matrix, Scalar* right) const {
    matrix.solve(right);
    if (slope_.empty()) return;
    const Scalar less = share_ * along(right);
    for (std::size_t i = 0; i < slope_.size(); ++i) right[i] = right[i] - less * solved_[i];
  }

 private:
  Scalar along(const Scalar* values) const {
    Scalar sum{};
    for (std::size_t i = 0; i < slope_.size(); ++i) sum = sum + slope_[i] * values[i];
    return sum;
  }

  std::vector<double> slope_;
  std::vector<Scalar> solved_;  // A^-1 g
  Scalar share_{};
};

}  // namespace taut::direct
