#include "sim/links/sparse_ldlt.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

#include "sim/motion/stop.h"

namespace taut {
namespace {

// A pivot this small beside what it was made from is rounding: the row depends on others.
constexpr double kDependent = 1e-12;
constexpr std::uint32_t kNoRow = 0xffffffff;

using Pattern = Eigen::SparseMatrix<double>;

/// The place of each row in an order of small fill.
std::vector<std::uint32_t> places(std::size_t rows,
                                  std::span<const SparseLdlt::Coupling> couplings) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(rows + 2 * couplings.size());
  for (std::size_t r = 0; r < rows; ++r) {
    entries.emplace_back(static_cast<int>(r), static_cast<int>(r), 1.0);
  }
  for (const auto& [row, other] : couplings) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(other), 1.0);
    entries.emplace_back(static_cast<int>(other), static_cast<int>(row), 1.0);
  }
  const auto size = static_cast<Eigen::Index>(rows);
  Pattern pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), order);
  std::vector<std::uint32_t> place(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    place[static_cast<std::size_t>(order.indices()[static_cast<Eigen::Index>(k)])] =
        static_cast<std::uint32_t>(k);
  }
  return place;
}

}  // namespace

void SparseLdlt::analyse(std::size_t rows, std::span<const Coupling> couplings) {
  rows_ = rows;
  const std::vector<std::uint32_t> place = places(rows, couplings);
  order_.resize(rows);
  for (std::uint32_t r = 0; r < rows; ++r) order_[place[r]] = r;

  known_of_.assign(rows + 1, 0);
  const auto later = [&](const Coupling& c) { return std::max(place[c.row], place[c.other]); };
  for (const Coupling& c : couplings) ++known_of_[later(c) + 1];
  for (std::size_t k = 0; k < rows; ++k) known_of_[k + 1] += known_of_[k];
  known_.resize(couplings.size());
  std::vector<std::uint32_t> next(known_of_.begin(), known_of_.end() - 1);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const Coupling& c = couplings[i];
    known_[next[later(c)]++] = {std::min(place[c.row], place[c.other]),
                                static_cast<std::uint32_t>(rows + i)};
  }

  // The row of L of each row: the columns that its couplings reach in the elimination tree.
  std::vector<std::uint32_t> parent(rows, kNoRow), seen(rows, kNoRow), entries(rows + 1, 0);
  reach_of_.assign(rows + 1, 0);
  reach_.clear();
  for (std::uint32_t k = 0; k < rows; ++k) {
    seen[k] = k;
    for (std::uint32_t i = known_of_[k]; i < known_of_[k + 1]; ++i) {
      for (std::uint32_t c = known_[i].column; seen[c] != k; c = parent[c]) {
        if (parent[c] == kNoRow) parent[c] = k;
        reach_.push_back(c);
        seen[c] = k;
      }
    }
    reach_of_[k + 1] = static_cast<std::uint32_t>(reach_.size());
    std::sort(reach_.begin() + reach_of_[k], reach_.end());
    for (std::uint32_t i = reach_of_[k]; i < reach_of_[k + 1]; ++i) ++entries[reach_[i] + 1];
  }
  products_ = 0;
  for (std::size_t c = 0; c < rows; ++c) {
    const double below = entries[c + 1];
    products_ += below * (below + 3) / 2;
    entries[c + 1] += entries[c];
  }
  column_of_ = std::move(entries);
  row_of_.resize(reach_.size());
  filled_.assign(rows, 0);
  for (std::uint32_t k = 0; k < rows; ++k) {
    for (std::uint32_t i = reach_of_[k]; i < reach_of_[k + 1]; ++i) {
      row_of_[column_of_[reach_[i]] + filled_[reach_[i]]++] = k;
    }
  }
  entry_.assign(reach_.size(), 0.0);
  inverse_.assign(rows, 0.0);
  scratch_.assign(rows, 0.0);
}

void SparseLdlt::factor(const double* values) {
  check_stop();
  dependent_ = 0;
  std::ranges::fill(filled_, 0u);
  for (std::size_t k = 0; k < rows_; ++k) {
    for (std::uint32_t i = known_of_[k]; i < known_of_[k + 1]; ++i) {
      scratch_[known_[i].column] = values[known_[i].value];
    }
    const double diagonal = values[order_[k]];
    double pivot = diagonal;
    for (std::uint32_t i = reach_of_[k]; i < reach_of_[k + 1]; ++i) {
      const std::uint32_t c = reach_[i], first = column_of_[c], last = first + filled_[c];
      const double value = scratch_[c];
      scratch_[c] = 0;
      for (std::uint32_t e = first; e < last; ++e) scratch_[row_of_[e]] -= entry_[e] * value;
      const double share = value * inverse_[c];
      pivot -= value * share;
      entry_[last] = share;
      ++filled_[c];
    }
    const bool independent = pivot > kDependent * diagonal;
    dependent_ += independent ? 0 : 1;
    inverse_[k] = independent ? 1 / pivot : 0;
  }
}

void SparseLdlt::solve(const double* right, double* x) {
  for (std::size_t k = 0; k < rows_; ++k) scratch_[k] = right[order_[k]];
  for (std::size_t c = 0; c < rows_; ++c) {
    const double value = scratch_[c];
    for (std::uint32_t e = column_of_[c]; e < column_of_[c + 1]; ++e) {
      scratch_[row_of_[e]] -= entry_[e] * value;
    }
  }
  for (std::size_t c = rows_; c-- > 0;) {
    double value = scratch_[c] * inverse_[c];
    for (std::uint32_t e = column_of_[c]; e < column_of_[c + 1]; ++e) {
      value -= entry_[e] * scratch_[row_of_[e]];
    }
    scratch_[c] = value;
  }
  for (std::size_t k = 0; k < rows_; ++k) x[order_[k]] = scratch_[k];
  std::ranges::fill(scratch_, 0.0);
}

}  // namespace taut
