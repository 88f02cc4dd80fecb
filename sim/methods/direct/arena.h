// The arrays of a course, in one block of memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>

#include "sim/methods/direct/vector.h"

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
  void reserve(std::size_t arrays, std::size_t size) { block_.reserve(arrays * stride(size)); }
  /// All arrays made before are void.
  void reset(std::size_t arrays, std::size_t size) {
    size_ = size;
    block_.assign(arrays * stride(size), 0.0);
    next_ = block_.data();
  }
  /// Another one, of zeros.
  Slice make() { return {std::exchange(next_, next_ + stride(size_)), size_}; }

 private:
  static constexpr std::size_t kLine = 8;  // numbers
  /// An odd number of lines.
  static std::size_t stride(std::size_t size) { return ((size + kLine - 1) / kLine | 1) * kLine; }

  std::size_t size_ = 0;
  Array block_;
  double* next_ = nullptr;
};

}  // namespace taut::direct
