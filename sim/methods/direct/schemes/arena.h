// What the schemes share: the arrays of an integrator, in one block of memory, and sums of stages
// with the weights of a tableau.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace taut::direct {

/// An array in an arena.
class Slice {
 public:
  Slice() = default;
  Slice(double* data, std::size_t size) : data_(data), size_(size) {}

  double* data() const { return data_; }
  std::size_t size() const { return size_; }
  double* begin() const { return data_; }
  double* end() const { return data_ + size_; }
  double operator[](std::size_t i) const { return data_[i]; }
  void swap(Slice& other) { std::swap(*this, other); }

 private:
  double* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Makes arrays of one size: each begins a cache line, and no two lie a multiple of a page apart,
/// where stores would hold up loads.
class Arena {
 public:
  /// Room for so many arrays.
  void reserve(std::size_t arrays, std::size_t size) { lines_.reserve(arrays * stride(size)); }
  /// All arrays made before are void.
  void reset(std::size_t arrays, std::size_t size) {
    size_ = size;
    lines_.clear();
    lines_.resize(arrays * stride(size));
    next_ = lines_.data();
  }
  /// Another one, of any numbers.
  Slice make() { return {std::exchange(next_, next_ + stride(size_))->numbers, size_}; }

  struct alignas(64) Line {
    Line() {}  // not even zeros
    double numbers[8];
  };
  /// The place of the next array; rewound to there, the arena makes those behind it again.
  Line* mark() const { return next_; }
  void rewind(Line* mark) { next_ = mark; }

 private:
  /// An odd number of lines.
  static std::size_t stride(std::size_t size) { return (size + 7) / 8 | 1; }

  std::size_t size_ = 0;
  std::vector<Line> lines_;
  Line* next_ = nullptr;
};

/// sum_k kRow[k] stage_k[i] over the first kCount stages whose weight is not zero, known when
/// compiled.
template <auto kRow, int kCount, int k = 0>
[[gnu::always_inline]] inline double combine(const double* const* stage, std::size_t i) {
  if constexpr (k == kCount) {
    return 0;
  } else if constexpr (kRow[k] == 0) {
    return combine<kRow, kCount, k + 1>(stage, i);
  } else {
    return kRow[k] * stage[k][i] + combine<kRow, kCount, k + 1>(stage, i);
  }
}

}  // namespace taut::direct
