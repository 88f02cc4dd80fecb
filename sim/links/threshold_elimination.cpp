#include "sim/links/threshold_elimination.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/stop.h"

namespace taut {

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

}  // namespace taut
