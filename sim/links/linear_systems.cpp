#include "sim/links/linear_systems.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "sim/motion/stop.h"

namespace taut {

void LeastSquares::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
}

Eigen::VectorXd LeastSquares::solve(const Eigen::VectorXd& right) const {
  return decomposed_.solve(right);
}

// By columns: a solver of many at once would be compiled, too.
Eigen::MatrixXd LeastSquares::solve(const Eigen::MatrixXd& right) const {
  Eigen::MatrixXd x(decomposed_.cols(), right.cols());
  for (Eigen::Index k = 0; k < right.cols(); ++k) {
    check_stop();
    x.col(k) = solve(Eigen::VectorXd(right.col(k)));
  }
  return x;
}

void LinearSystem::compute(const Eigen::MatrixXd& matrix) {
  decomposed_.compute(matrix);
  const auto pivots = decomposed_.matrixLU().diagonal().cwiseAbs();
  is_singular_ = pivots.size() > 0 && !(pivots.minCoeff() > kDependent * pivots.maxCoeff());
  if (is_singular_) dependent_.compute(matrix);
}

void LinearSystem::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) const {
  if (is_singular_) {
    x = dependent_.solve(right);
  } else {
    x = decomposed_.solve(right);
  }
}

namespace {

constexpr double kThreshold = 0.1;  // of the largest entry beside a pivot
constexpr std::size_t kFew = 8;     // an elimination of so small a share of all entries is cheap

}  // namespace

/// Whether the row may be eliminated on its diagonal now; its entries beside that are then the last
/// of rows_ and columns_.
bool ThresholdElimination::takes(Eigen::Index pivot) {
  const std::size_t rows = rows_.size(), columns = columns_.size();
  double most = 0;
  for (const Eigen::Index other : rest_) {
    if (other == pivot) continue;
    const double below = work_(other, pivot), beside = work_(pivot, other);
    if (below != 0) rows_.push_back(other);
    if (beside != 0) columns_.push_back(other);
    most = std::max({most, std::abs(below), std::abs(beside)});
  }
  const std::size_t entries = (rows_.size() - rows) * (columns_.size() - columns);
  const bool few = kFew * entries <= rest_.size() * rest_.size();
  if (few && work_(pivot, pivot) != 0 && std::abs(work_(pivot, pivot)) >= kThreshold * most) {
    return true;
  }
  rows_.resize(rows);
  columns_.resize(columns);
  return false;
}

void ThresholdElimination::compute(const Eigen::MatrixXd& matrix) {
  work_ = matrix;
  const Eigen::Index size = matrix.rows();
  steps_.clear();
  rows_.clear();
  columns_.clear();
  rest_.resize(static_cast<std::size_t>(size));
  for (Eigen::Index i = 0; i < size; ++i) rest_[static_cast<std::size_t>(i)] = i;
  std::size_t rows = 0, columns = 0;
  for (Eigen::Index pivot = size - 1; pivot >= 0; --pivot) {
    check_stop();
    if (!takes(pivot)) continue;
    for (; rows < rows_.size(); ++rows) {
      const double factor = work_(rows_[rows], pivot) /= work_(pivot, pivot);
      for (std::size_t c = columns; c < columns_.size(); ++c) {
        work_(rows_[rows], columns_[c]) -= factor * work_(pivot, columns_[c]);
      }
    }
    columns = columns_.size();
    steps_.push_back({pivot, rows, columns});
    rest_.erase(std::ranges::find(rest_, pivot));
  }
  const auto left = static_cast<Eigen::Index>(rest_.size());
  rest_matrix_.resize(left, left);
  rest_right_.resize(left);
  for (Eigen::Index j = 0; j < left; ++j) {
    for (Eigen::Index i = 0; i < left; ++i) {
      rest_matrix_(i, j) =
          work_(rest_[static_cast<std::size_t>(i)], rest_[static_cast<std::size_t>(j)]);
    }
  }
  if (left > 0) rest_system_.compute(rest_matrix_);
}

void ThresholdElimination::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) {
  x = right;
  std::size_t row = 0;
  for (const Step& step : steps_) {
    for (; row < step.rows_end; ++row)
      x[rows_[row]] -= work_(rows_[row], step.pivot) * x[step.pivot];
  }
  const auto left = static_cast<Eigen::Index>(rest_.size());
  for (Eigen::Index i = 0; i < left; ++i) rest_right_[i] = x[rest_[static_cast<std::size_t>(i)]];
  if (left > 0) rest_system_.solve(rest_right_, rest_x_);
  for (Eigen::Index i = 0; i < left; ++i) x[rest_[static_cast<std::size_t>(i)]] = rest_x_[i];
  for (std::size_t k = steps_.size(); k-- > 0;) {
    const Step& step = steps_[k];
    double& own = x[step.pivot];
    for (std::size_t c = k > 0 ? steps_[k - 1].columns_end : 0; c < step.columns_end; ++c) {
      own -= work_(step.pivot, columns_[c]) * x[columns_[c]];
    }
    own /= work_(step.pivot, step.pivot);
  }
}

namespace {

// A pivot this small beside what it was made from is rounding: the row depends on others.
constexpr double kVanishing = 1e-12;
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
    const bool independent = pivot > kVanishing * diagonal;
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
