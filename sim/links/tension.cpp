#include "sim/links/tension.h"

#include <algorithm>
#include <numeric>

namespace taut {
namespace {

// A pivot this small beside what it was made from is rounding: A is singular.
constexpr double kSingular = 1e-12;

/// True where `row` and the next are neighbouring links of one connector.
bool neighbours(const std::vector<Row>& rows, std::size_t row) {
  return row + 1 < rows.size() && rows[row].axis == Row::kAlongLink &&
         rows[row + 1].axis == Row::kAlongLink && rows[row].b == rows[row + 1].a;
}

}  // namespace

void TensionSystem::rebuild(const Mechanism& mechanism) {
  rows_ = mechanism.rows().size();
  is_joined_ = mechanism.is_joined();
  if (is_joined_) return joined_.rebuild(mechanism);
  const std::size_t room = mechanism.row_room();
  values_.reserve(2 * room);
  border_index_.reserve(room);
  inverse_pivot_.reserve(room);
  factor_.reserve(room);
  values_.assign(2 * rows_, 0.0);
  inverse_pivot_.resize(rows_);
  factor_.resize(rows_);
  find_terms(mechanism);
  find_border();
}

/// The index into values_ of A(row, other), row <= other.
std::uint32_t TensionSystem::entry(const Mechanism& mechanism, std::size_t row, std::size_t other) {
  if (row == other) return small(row);
  if (other == row + 1 && neighbours(mechanism.rows(), row)) return small(rows_ + row);
  const auto found = std::ranges::find_if(
      entries_, [&](const Entry& e) { return e.row == row && e.other == other; });
  if (found != entries_.end()) return found->value;
  entries_.push_back({small(row), small(other), small(values_.size())});
  values_.push_back(0);
  return entries_.back().value;
}

void TensionSystem::find_terms(const Mechanism& mechanism) {
  entries_.clear();
  point_terms_.clear();
  body_terms_.clear();
  const auto& rows = mechanism.rows();
  for (std::size_t r = 0; r < rows_; ++r) {
    // Rows of a connector stand together; those that share a point are at most six apart.
    for (std::size_t s = r + 1; s < rows_ && rows[s].a <= rows[r].b; ++s) {
      if (s == r + 1 && neighbours(rows, r)) continue;  // in assemble()'s own loop
      for (const std::uint32_t point : {rows[s].a, rows[s].b}) {
        const double w = mechanism.inverse_mass()[point];
        if (w == 0 || (point != rows[r].a && point != rows[r].b)) continue;
        const bool same_side = (point == rows[r].a) == (point == rows[s].a);
        point_terms_.push_back({small(r), small(s), entry(mechanism, r, s), same_side ? w : -w});
      }
    }
  }
  const auto& row_ends = mechanism.row_ends();
  const auto body = [&](std::size_t g) {
    return mechanism.body_points()[row_ends[g].body_point].body;
  };
  for (std::size_t g = 0; g < row_ends.size(); ++g) {
    for (std::size_t h = g; h < row_ends.size(); ++h) {
      if (body(g) != body(h)) continue;
      const auto [row, other] = std::minmax(row_ends[g].row, row_ends[h].row);
      const double times = row == other && g != h ? 2 : 1;
      body_terms_.push_back({small(g), small(h), entry(mechanism, row, other), times});
    }
  }
}

void TensionSystem::find_border() {
  border_.clear();
  border_entries_.clear();
  border_index_.assign(rows_, kInside);
  for (const Entry& e : entries_) {
    for (const std::uint32_t row : {e.row, e.other}) {
      if (border_index_[row] != kInside) continue;
      border_index_[row] = small(border_.size());
      border_.push_back(row);
    }
  }
  for (const std::uint32_t row : border_) {
    if (row > 0) border_entries_.push_back({row, row - 1, small(rows_ + row - 1)});
    if (row + 1 < rows_) border_entries_.push_back({row, row + 1, small(rows_ + row)});
    for (const Entry& e : entries_) {
      if (e.row == row) border_entries_.push_back(e);
      if (e.other == row) border_entries_.push_back({row, e.row, e.value});
    }
  }
  const auto size = static_cast<Eigen::Index>(border_.size());
  columns_.resize(rows_ * border_.size());
  schur_.resize(size, size);
  border_x_.resize(size);
}

void TensionSystem::assemble(const Mechanism& mechanism) {
  if (is_joined_) return joined_.assemble(mechanism);
  const auto& rows = mechanism.rows();
  const auto& w = mechanism.inverse_mass();
  const auto& direction = mechanism.direction();
  double* beside = values_.data() + rows_;
  for (std::size_t r = 0; r < rows_; ++r) {
    values_[r] = (w[rows[r].a] + w[rows[r].b]) * direction[r].squaredNorm();
    beside[r] = neighbours(rows, r) ? -w[rows[r].b] * direction[r].dot(direction[r + 1]) : 0;
  }
  std::fill(values_.begin() + static_cast<std::ptrdiff_t>(2 * rows_), values_.end(), 0.0);
  for (const PointTerm& term : point_terms_) {
    values_[term.value] += term.weight * direction[term.row].dot(direction[term.other]);
  }
  for (const BodyTerm& term : body_terms_) {
    const auto& g = mechanism.row_ends()[term.end];
    const auto& h = mechanism.row_ends()[term.other];
    const auto& body = mechanism.bodies()[mechanism.body_points()[g.body_point].body];
    const Vec3 pull = g.sign * direction[g.row], other = h.sign * direction[h.row];
    const Vec3 torque = mechanism.body_points()[g.body_point].arm.cross(pull);
    const Vec3 other_torque = mechanism.body_points()[h.body_point].arm.cross(other);
    values_[term.value] += term.times * (body.inverse_mass * pull.dot(other) +
                                         torque.dot(body.world_inverse * other_torque));
  }
}

double TensionSystem::next(std::size_t row) const {
  const bool inside =
      border_index_[row] == kInside && row + 1 < rows_ && border_index_[row + 1] == kInside;
  return inside ? values_[rows_ + row] : 0;
}

bool TensionSystem::eliminate() {
  double before = 0;  // what the row above takes from the diagonal
  for (std::size_t r = 0; r < rows_; ++r) {
    const bool inside = border_index_[r] == kInside;
    const double diagonal = inside ? values_[r] : 1;
    const double pivot = diagonal - before;
    if (!(pivot > kSingular * diagonal)) return false;
    inverse_pivot_[r] = 1 / pivot;
    const double e = next(r);
    factor_[r] = e * inverse_pivot_[r];
    before = e * factor_[r];
  }
  return true;
}

template <class Vector>
void TensionSystem::sweep(Vector&& x) const {
  for (std::size_t r = 1; r < rows_; ++r) x[r] -= factor_[r - 1] * x[r - 1];
  x[rows_ - 1] *= inverse_pivot_[rows_ - 1];
  for (std::size_t r = rows_ - 1; r-- > 0;) {
    x[r] = x[r] * inverse_pivot_[r] - factor_[r] * x[r + 1];
  }
}

bool TensionSystem::solve_banded(const std::vector<double>& right, std::vector<double>& x) {
  x = right;
  if (rows_ == 0) return true;
  if (!eliminate()) return false;
  for (const std::uint32_t row : border_) x[row] = 0;
  sweep(x.data());
  if (border_.empty()) return true;

  std::ranges::fill(columns_, 0.0);
  const auto column = [&](std::size_t s) { return columns_.data() + s * rows_; };
  schur_.setZero();
  for (std::size_t s = 0; s < border_.size(); ++s) {
    const auto i = static_cast<Eigen::Index>(s);
    schur_(i, i) = values_[border_[s]];
    border_x_[i] = right[border_[s]];
  }
  for (const Entry& e : border_entries_) {
    const auto s = border_index_[e.row], t = border_index_[e.other];
    (t == kInside ? column(s)[e.other] : schur_(s, t)) = values_[e.value];
  }
  const double largest = schur_.diagonal().maxCoeff();
  for (std::size_t s = 0; s < border_.size(); ++s) sweep(column(s));
  for (const Entry& e : border_entries_) {
    if (border_index_[e.other] != kInside) continue;
    const auto s = border_index_[e.row];
    for (std::size_t t = 0; t < border_.size(); ++t) {
      schur_(s, static_cast<Eigen::Index>(t)) -= values_[e.value] * column(t)[e.other];
    }
    border_x_[s] -= values_[e.value] * x[e.other];
  }
  border_solver_.compute(schur_);
  if (!(border_solver_.vectorD().minCoeff() > kSingular * largest)) return false;
  border_solver_.solveInPlace(border_x_);
  for (std::size_t s = 0; s < border_.size(); ++s) {
    const double share = border_x_[static_cast<Eigen::Index>(s)];
    for (std::size_t r = 0; r < rows_; ++r) x[r] -= column(s)[r] * share;
  }
  for (std::size_t s = 0; s < border_.size(); ++s) {
    x[border_[s]] = border_x_[static_cast<Eigen::Index>(s)];
  }
  return true;
}

const Eigen::MatrixXd& TensionSystem::dense() {
  const auto size = static_cast<Eigen::Index>(rows_);
  dense_.setZero(size, size);
  for (Eigen::Index r = 0; r < size; ++r) {
    dense_(r, r) = values_[static_cast<std::size_t>(r)];
    if (r + 1 < size)
      dense_(r, r + 1) = dense_(r + 1, r) = values_[rows_ + static_cast<std::size_t>(r)];
  }
  for (const Entry& e : entries_)
    dense_(e.row, e.other) = dense_(e.other, e.row) = values_[e.value];
  return dense_;
}

void TensionSystem::solve_dense(const std::vector<double>& right, std::vector<double>& x) {
  if (rows_ == 0) return;
  dense_solver_.compute(dense());
  dense_right_ = Eigen::Map<const Eigen::VectorXd>(right.data(), static_cast<Eigen::Index>(rows_));
  dense_right_ = dense_solver_.solve(dense_right_);
  x.assign(dense_right_.data(), dense_right_.data() + dense_right_.size());
}

bool TensionSystem::solve(const std::vector<double>& right, std::vector<double>& x) {
  if (is_joined_) return joined_.solve(right, x);
  if (solve_banded(right, x)) return true;
  solve_blocks(right, x);
  return false;
}

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
