// Tensions where A is singular: each block of rows that couple by itself.
#include <algorithm>
#include <numeric>

#include "sim/links/tension.h"

namespace taut {

/// Which rows couple, as the values of A are.
void TensionSystem::find_blocks() {
  block_.resize(rows_);
  std::iota(block_.begin(), block_.end(), 0u);
  const auto first = [&](std::uint32_t row) {
    while (block_[row] != row) row = block_[row] = block_[block_[row]];
    return row;
  };
  const auto unite = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t one = first(a), other = first(b);
    block_[std::max(one, other)] = std::min(one, other);
  };
  for (std::uint32_t r = 0; r + 1 < rows_; ++r) {
    if (values_[rows_ + r] != 0) unite(r, r + 1);
  }
  for (const Entry& e : entries_) unite(e.row, e.other);
  for (std::uint32_t r = 0; r < rows_; ++r) block_[r] = first(r);
  block_rows_.resize(rows_);
  std::iota(block_rows_.begin(), block_rows_.end(), 0u);
  std::ranges::stable_sort(block_rows_, {}, [&](std::uint32_t row) { return block_[row]; });
  block_entries_.resize(entries_.size());
  std::iota(block_entries_.begin(), block_entries_.end(), 0u);
  std::ranges::stable_sort(block_entries_, {},
                           [&](std::uint32_t e) { return block_[entries_[e].row]; });
}

void TensionSystem::solve_blocks(const std::vector<double>& right, std::vector<double>& x) {
  find_blocks();
  place_.resize(rows_);
  x.resize(rows_);
  std::size_t entry = 0;
  for (std::size_t begin = 0, end = 0; begin < rows_; begin = end) {
    const std::uint32_t block = block_[block_rows_[begin]];
    const std::size_t from = entry;
    for (; end < rows_ && block_[block_rows_[end]] == block; ++end) {
      place_[block_rows_[end]] = small(end - begin);
    }
    while (entry < entries_.size() && block_[entries_[block_entries_[entry]].row] == block) ++entry;
    solve_block(std::span(block_rows_).subspan(begin, end - begin),
                std::span(block_entries_).subspan(from, entry - from), right, x);
  }
}

void TensionSystem::solve_block(std::span<const std::uint32_t> rows,
                                std::span<const std::uint32_t> entries,
                                const std::vector<double>& right, std::vector<double>& x) {
  if (entries.empty()) {  // neighbours, one behind the other
    double before = 0, moved = 0;
    bool singular = false;
    for (const std::uint32_t r : rows) {
      const double pivot = values_[r] - before;
      if ((singular = !(pivot > kSingular * values_[r]))) break;
      inverse_pivot_[r] = 1 / pivot;
      factor_[r] = values_[rows_ + r] * inverse_pivot_[r];
      x[r] = right[r] - moved;
      moved = factor_[r] * x[r];
      before = values_[rows_ + r] * factor_[r];
    }
    if (!singular) {
      double behind = 0;
      for (std::size_t i = rows.size(); i-- > 0;) {
        x[rows[i]] = behind = x[rows[i]] * inverse_pivot_[rows[i]] - factor_[rows[i]] * behind;
      }
      return;
    }
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  dense_.setZero(size, size);
  dense_right_.resize(size);
  for (const std::uint32_t r : rows) {
    const auto i = static_cast<Eigen::Index>(place_[r]);
    dense_(i, i) = values_[r];
    dense_right_[i] = right[r];
    if (values_[rows_ + r] == 0) continue;
    const auto j = static_cast<Eigen::Index>(place_[r + 1]);
    dense_(i, j) = dense_(j, i) = values_[rows_ + r];
  }
  for (const std::uint32_t e : entries) {
    const Entry& at = entries_[e];
    dense_(place_[at.row], place_[at.other]) = values_[at.value];
    dense_(place_[at.other], place_[at.row]) = values_[at.value];
  }
  dense_solver_.compute(dense_);
  dense_right_ = dense_solver_.solve(dense_right_);
  for (const std::uint32_t r : rows) x[r] = dense_right_[place_[r]];
}

}  // namespace taut
