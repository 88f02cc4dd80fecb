// L D L^T of a symmetric band matrix, real or complex symmetric, without exchanges; and solves with
// a product of one vector with itself on top of it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace taut::direct {

/// A complex number whose product is four multiplications and nothing else.
struct Complex {
  double re = 0, im = 0;

  friend Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
  friend Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(Complex a, Complex b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend Complex operator*(double a, Complex b) { return {a * b.re, a * b.im}; }
};

inline double inverse(double x) {
  return 1 / x;
}
inline Complex inverse(Complex x) {
  const double scale = 1 / (x.re * x.re + x.im * x.im);
  return {scale * x.re, -scale * x.im};
}

/// Rows are coupled with `kHalf` before and behind. Stable without exchanges where the matrix is
/// definite once the multipliers, each behind the rows that it couples, are eliminated.
template <class Scalar, std::size_t kHalf>
class BandLdlt {
 public:
  static constexpr std::size_t kWidth = kHalf + 1;

  void resize(std::size_t rows) {
    rows_ = rows;
    band_.resize(rows * kWidth);
    inverse_.resize(rows);
  }
  void clear() { std::fill(band_.begin(), band_.end(), Scalar{}); }
  /// The entry of the matrix, before factor(); `column` at most `row`.
  Scalar& at(std::size_t row, std::size_t column) {
    return band_[row * kWidth + kHalf + column - row];
  }
  Scalar* row(std::size_t row) { return &band_[row * kWidth]; }

  void factor() {
    std::array<Scalar, kWidth> scaled;  // the row of L D
    for (std::size_t r = 0; r < rows_; ++r) {
      Scalar* own = row(r);
      const std::size_t first = r < kHalf ? kHalf - r : 0;  // where the row begins
      Scalar pivot = own[kHalf];
      for (std::size_t c = first; c < kHalf; ++c) {
        // The row of column c's unknown is shifted by kHalf - c against this one.
        const std::size_t shift = kHalf - c;
        const Scalar* other = row(r - shift);
        Scalar value = own[c];
        for (std::size_t k = first; k < c; ++k) value = value - scaled[k] * other[k + shift];
        scaled[c] = value;
        own[c] = value * inverse_[r - shift];
        pivot = pivot - value * own[c];
      }
      inverse_[r] = inverse(pivot);
    }
  }

  void solve(Scalar* x) const {
    for (std::size_t r = 0; r < rows_; ++r) {
      const Scalar* own = &band_[r * kWidth];
      const std::size_t first = r < kHalf ? kHalf - r : 0;
      Scalar value = x[r];
      for (std::size_t c = first; c < kHalf; ++c) value = value - own[c] * x[r + c - kHalf];
      x[r] = value;
    }
    for (std::size_t r = 0; r < rows_; ++r) x[r] = inverse_[r] * x[r];
    for (std::size_t r = rows_; r-- > 0;) {  // what is behind has been taken off x[r] already
      const Scalar* own = &band_[r * kWidth];
      const std::size_t first = r < kHalf ? kHalf - r : 0;
      const Scalar value = x[r];
      for (std::size_t c = first; c < kHalf; ++c) {
        x[r + c - kHalf] = x[r + c - kHalf] - own[c] * value;
      }
    }
  }

 private:
  std::size_t rows_ = 0;
  std::vector<Scalar> band_;  // per row: kHalf entries of L, then the diagonal
  std::vector<Scalar> inverse_;
};

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
