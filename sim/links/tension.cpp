#include "sim/links/tension.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut {
namespace {

/// True where `row` and the next are neighbouring links of one connector.
bool neighbours(const std::vector<Row>& rows, std::size_t row) {
  return row + 1 < rows.size() && rows[row].axis == Row::kAlongLink &&
         rows[row + 1].axis == Row::kAlongLink && rows[row].b == rows[row + 1].a;
}

}  // namespace

void TensionSystem::rebuild(const Mechanism& mechanism) {
  rows_ = mechanism.unknowns();
  pulleys_ = mechanism.pulleys();
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
  find_border(mechanism);
}

/// The index into values_ of A(row, other), row <= other.
std::uint32_t TensionSystem::entry(const Mechanism& mechanism, std::size_t row, std::size_t other) {
  if (row == other) return small(row);
  if (other == row + 1 && neighbours(mechanism.rows(), row)) return small(rows_ + row);
  const auto [found, added] = entry_at_.try_emplace({row, other}, small(values_.size()));
  if (!added) return found->second;
  entries_.push_back({small(row), small(other), small(values_.size()), small(values_.size())});
  values_.push_back(0);
  return entries_.back().value;
}

void TensionSystem::find_terms(const Mechanism& mechanism) {
  entries_.clear();
  entry_at_.clear();
  point_terms_.clear();
  body_terms_.clear();
  const auto& rows = mechanism.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    // Rows of a connector stand together; those that share a point are at most six apart.
    for (std::size_t s = r + 1; s < rows.size() && rows[s].a <= rows[r].b; ++s) {
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
  couplings_.clear();
  for (const Mechanism::Coupling& coupling : mechanism.couplings()) {
    couplings_.push_back(entry(mechanism, coupling.row, rows.size() + coupling.pulley));
  }
  pulley_pairs_.clear();
  for (std::size_t p = rows.size(); p < rows_; ++p) {
    for (std::size_t q = p; q < rows_; ++q) pulley_pairs_.push_back(entry(mechanism, p, q));
  }
  for (Entry& e : entries_) {
    if (e.other < rows.size()) continue;
    e.transposed = small(values_.size());
    values_.push_back(0);
  }
}

void TensionSystem::add_to_border(std::size_t row) {
  if (border_index_[row] != kInside) return;
  border_index_[row] = small(border_.size());
  border_.push_back(small(row));
}

void TensionSystem::find_border(const Mechanism& mechanism) {
  border_.clear();
  border_entries_.clear();
  border_index_.assign(rows_, kInside);
  const auto& rows = mechanism.rows();
  for (const Entry& e : entries_) {
    if (e.other >= rows.size()) continue;  // a pulley's
    add_to_border(e.row);
    add_to_border(e.other);
  }
  // The rows of a connector between two ends that hardly move are nearly dependent: without one of
  // them they are not.
  for (std::size_t c = 0; c < mechanism.couplings().size(); ++c) {
    const std::uint32_t row = mechanism.couplings()[c].row, connector = rows[row].connector;
    const auto of_it = [&](std::uint32_t r) {
      return r < rows.size() && rows[r].connector == connector;
    };
    if (std::ranges::none_of(border_, of_it)) add_to_border(row);
  }
  for (std::size_t p = rows.size(); p < rows_; ++p) add_to_border(p);
  for (const std::uint32_t row : border_) {
    const auto beside = [&](std::uint32_t other, std::size_t value) {
      border_entries_.push_back({row, other, small(value), small(value)});
    };
    if (row > 0) beside(row - 1, rows_ + row - 1);
    if (row + 1 < rows_) beside(row + 1, rows_ + row);
    for (const Entry& e : entries_) {
      if (e.row == row) border_entries_.push_back(e);
      if (e.other == row) border_entries_.push_back({row, e.row, e.transposed, e.value});
    }
  }
  // The rows inside that a column of the border reaches by their couplings to each other.
  const auto coupled = [&](std::size_t row) {
    return border_index_[row] == kInside && border_index_[row + 1] == kInside &&
           neighbours(rows, row);
  };
  column_spans_.assign(border_.size(), {});
  for (const Entry& e : border_entries_) {
    if (border_index_[e.other] != kInside) continue;
    RowSpan& span = column_spans_[border_index_[e.row]];
    if (span.has(e.other)) continue;
    std::size_t from = e.other, until = e.other + 1;
    while (from > 0 && coupled(from - 1)) --from;
    while (until < rows_ && coupled(until - 1)) ++until;
    if (span.from < span.until) {
      from = std::min<std::size_t>(from, span.from);
      until = std::max<std::size_t>(until, span.until);
    }
    span = {from, until};
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
  for (std::size_t r = 0; r < rows.size(); ++r) {
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
  const auto entry_of = [&](std::uint32_t value) { return entries_[value - 2 * rows_]; };
  for (std::size_t c = 0; c < couplings_.size(); ++c) {
    const Entry e = entry_of(couplings_[c]);
    values_[e.value] = -mechanism.couplings()[c].value;
    values_[e.transposed] = mechanism.couplings()[c].drive;
  }
  auto pair = pulley_pairs_.begin();
  for (Eigen::Index p = 0; p < static_cast<Eigen::Index>(pulleys_); ++p) {
    values_[*pair++] = -mechanism.passing_inertia()(p, p);
    for (Eigen::Index q = p + 1; q < static_cast<Eigen::Index>(pulleys_); ++q) {
      const Entry e = entry_of(*pair++);
      values_[e.value] = -mechanism.passing_inertia()(p, q);
      values_[e.transposed] = -mechanism.passing_inertia()(q, p);
    }
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

/// Solves for the rows of `span` inside, which are not coupled to others there.
void TensionSystem::sweep(RowSpan span, double* x) const {
  if (span.from >= span.until) return;
  for (std::size_t r = span.from + 1; r < span.until; ++r) x[r] -= factor_[r - 1] * x[r - 1];
  x[span.until - 1] *= inverse_pivot_[span.until - 1];
  for (std::size_t r = span.until - 1; r-- > span.from;) {
    x[r] = x[r] * inverse_pivot_[r] - factor_[r] * x[r + 1];
  }
}

bool TensionSystem::solve_banded(const std::vector<double>& right, std::vector<double>& x) {
  x = right;
  if (rows_ == 0) return true;
  if (!eliminate()) return false;
  for (const std::uint32_t row : border_) x[row] = 0;
  sweep({0, rows_}, x.data());
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
    if (t == kInside) {
      column(s)[e.other] = values_[e.transposed];
    } else {
      schur_(s, t) = values_[e.value];
    }
  }
  const double largest = schur_.diagonal().maxCoeff();
  for (std::size_t s = 0; s < border_.size(); ++s) sweep(column_spans_[s], column(s));
  for (const Entry& e : border_entries_) {
    if (border_index_[e.other] != kInside) continue;
    const auto s = border_index_[e.row];
    for (std::size_t t = 0; t < border_.size(); ++t) {
      if (!column_spans_[t].has(e.other)) continue;
      schur_(s, static_cast<Eigen::Index>(t)) -= values_[e.value] * column(t)[e.other];
    }
    border_x_[s] -= values_[e.value] * x[e.other];
  }
  if (pulleys_ > 0) {
    solve_border();
  } else {
    border_solver_.compute(schur_);
    if (!(border_solver_.vectorD().minCoeff() > kSingular * largest)) return false;
    border_solver_.solveInPlace(border_x_);
  }
  for (std::size_t s = 0; s < border_.size(); ++s) {
    const double share = border_x_[static_cast<Eigen::Index>(s)];
    for (std::size_t r = column_spans_[s].from; r < column_spans_[s].until; ++r) {
      x[r] -= column(s)[r] * share;
    }
  }
  for (std::size_t s = 0; s < border_.size(); ++s) {
    x[border_[s]] = border_x_[static_cast<Eigen::Index>(s)];
  }
  return true;
}

/// Of a border with pulleys, whose rows and columns are of many sizes.
void TensionSystem::solve_border() {
  const Eigen::Index size = schur_.rows();
  scale_.setOnes(size);
  for (Eigen::Index r = 0; r < size; ++r) {  // as Ruiz: the largest of each row comes near one
    const double largest = schur_.col(r).cwiseAbs().cwiseProduct(scale_).maxCoeff();
    if (largest > 0) scale_[r] /= std::sqrt(largest * scale_[r]);
  }
  for (Eigen::Index r = 0; r < size; ++r) {
    schur_.col(r).array() *= scale_.array() * scale_[r];
    border_x_[r] *= scale_[r];
  }
  scaled_right_ = border_x_;
  pulley_solver_.compute(schur_);
  pulley_solver_.solve(scaled_right_, border_x_);
  constexpr double kOff = 1e-6;  // beside the right side: no solution
  residual_ = scaled_right_;
  residual_.noalias() -= schur_ * border_x_;
  if (!(residual_.norm() <= kOff * scaled_right_.norm())) {
    dense_solver_.compute(schur_);
    border_x_ = dense_solver_.solve(scaled_right_);
  }
  border_x_.array() *= scale_.array();
}

const Eigen::MatrixXd& TensionSystem::dense() {
  const auto size = static_cast<Eigen::Index>(rows_);
  dense_.setZero(size, size);
  for (Eigen::Index r = 0; r < size; ++r) {
    dense_(r, r) = values_[static_cast<std::size_t>(r)];
    if (r + 1 < size)
      dense_(r, r + 1) = dense_(r + 1, r) = values_[rows_ + static_cast<std::size_t>(r)];
  }
  for (const Entry& e : entries_) {
    dense_(e.row, e.other) = values_[e.value];
    dense_(e.other, e.row) = values_[e.transposed];
  }
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
  if (pulleys_ > 0) {  // links without any mass between them
    x.assign(rows_, std::numeric_limits<double>::quiet_NaN());
  } else {
    solve_blocks(right, x);
  }
  return false;
}

}  // namespace taut
