#include "sim/links/tension.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/motion/stop.h"

namespace taut {
namespace {

/// What a pull at one of two ends at a free body does to the row of the other, 1/kg.
double through_body(const Mechanism& mechanism, const Mechanism::RowEnd& end,
                    const Mechanism::RowEnd& other) {
  const auto& point = mechanism.body_points()[end.body_point];
  const auto& body = mechanism.bodies()[point.body];
  const Vec3 pull = end.sign * mechanism.direction()[end.row];
  const Vec3 other_pull = other.sign * mechanism.direction()[other.row];
  const Vec3 torque = point.arm.cross(pull);
  const Vec3 other_torque = mechanism.body_points()[other.body_point].arm.cross(other_pull);
  return body.inverse_mass * pull.dot(other_pull) + torque.dot(body.world_inverse * other_torque);
}

/// True where `row` and the next are neighbouring links of one connector.
bool neighbours(const std::vector<Row>& rows, std::size_t row) {
  return row + 1 < rows.size() && rows[row].axis == Row::kAlongLink &&
         rows[row + 1].axis == Row::kAlongLink && rows[row].b == rows[row + 1].a;
}

}  // namespace

void JoinedTension::rebuild(const Mechanism& mechanism) {
  rows_ = mechanism.rows().size();
  find_point_terms(mechanism);
  find_body_terms(mechanism);
  find_pattern();
}

void JoinedTension::find_point_terms(const Mechanism& mechanism) {
  const auto& rows = mechanism.rows();
  std::vector<std::vector<std::uint32_t>> at(mechanism.points());
  for (std::uint32_t r = 0; r < rows_; ++r) {
    at[rows[r].a].push_back(r);
    at[rows[r].b].push_back(r);
  }
  point_terms_.clear();
  for (std::uint32_t point = 0; point < at.size(); ++point) {
    if (mechanism.inverse_mass()[point] == 0) continue;
    for (std::size_t i = 0; i < at[point].size(); ++i) {
      for (std::size_t j = i + 1; j < at[point].size(); ++j) {
        const std::uint32_t row = at[point][i], other = at[point][j];
        const bool same_side = (point == rows[row].a) == (point == rows[other].a);
        point_terms_.push_back({row, other, 0, point, same_side ? 1.0 : -1.0});
      }
    }
  }
}

void JoinedTension::find_body_terms(const Mechanism& mechanism) {
  const auto& ends = mechanism.row_ends();
  std::vector<std::vector<std::uint32_t>> on(mechanism.bodies().size());
  for (std::uint32_t g = 0; g < ends.size(); ++g) {
    on[mechanism.body_points()[ends[g].body_point].body].push_back(g);
  }
  body_terms_.clear();
  for (const std::vector<std::uint32_t>& list : on) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (std::size_t j = i; j < list.size(); ++j) {
        const bool twice = i != j && ends[list[i]].row == ends[list[j]].row;
        body_terms_.push_back({list[i], list[j], 0, twice ? 2.0 : 1.0});
      }
    }
  }
  row_of_end_.clear();
  for (const auto& end : ends) row_of_end_.push_back(end.row);
}

/// Numbers the values of the terms: the rows' diagonal first, then pairs of rows as they rise.
void JoinedTension::find_pattern() {
  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Pair> pairs;
  const auto pair = [](std::uint32_t a, std::uint32_t b) { return Pair(std::minmax(a, b)); };
  const auto pair_of = [&](const BodyTerm& term) {
    return pair(row_of_end_[term.end], row_of_end_[term.other]);
  };
  for (const PointTerm& term : point_terms_) pairs.push_back(pair(term.row, term.other));
  for (const BodyTerm& term : body_terms_) pairs.push_back(pair_of(term));
  std::erase_if(pairs, [](const Pair& p) { return p.first == p.second; });
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  const auto value = [&](const Pair& p) {
    if (p.first == p.second) return p.first;
    return small(rows_) +
           small(static_cast<std::size_t>(std::ranges::lower_bound(pairs, p) - pairs.begin()));
  };
  for (PointTerm& term : point_terms_) term.value = value(pair(term.row, term.other));
  for (BodyTerm& term : body_terms_) term.value = value(pair_of(term));
  std::vector<SparseLdlt::Coupling> couplings;
  couplings.reserve(pairs.size());
  for (const auto& [row, other] : pairs) couplings.push_back({row, other});
  ldlt_.analyse(rows_, couplings);
  values_.assign(rows_ + pairs.size(), 0.0);
}

void JoinedTension::assemble(const Mechanism& mechanism) {
  const auto& rows = mechanism.rows();
  const auto& w = mechanism.inverse_mass();
  const auto& direction = mechanism.direction();
  std::ranges::fill(values_, 0.0);
  for (std::size_t r = 0; r < rows_; ++r) {
    values_[r] = (w[rows[r].a] + w[rows[r].b]) * direction[r].squaredNorm();
  }
  for (const PointTerm& term : point_terms_) {
    values_[term.value] +=
        term.sign * w[term.point] * direction[term.row].dot(direction[term.other]);
  }
  const auto& ends = mechanism.row_ends();
  for (const BodyTerm& term : body_terms_) {
    values_[term.value] += term.times * through_body(mechanism, ends[term.end], ends[term.other]);
  }
}

bool JoinedTension::solve(const std::vector<double>& right, std::vector<double>& x) {
  x.resize(rows_);
  ldlt_.factor(values_.data());
  ldlt_.solve(right.data(), x.data());
  return ldlt_.dependent() == 0;
}

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
  const auto& ends = mechanism.row_ends();
  for (const BodyTerm& term : body_terms_) {
    values_[term.value] += term.times * through_body(mechanism, ends[term.end], ends[term.other]);
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

// Tensions where A is singular: each block of rows that couple by itself.

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

double winch_tension(const World& world, std::size_t index, std::size_t end) {
  const Connector& connector = world.connectors[index];
  if (!connector.winch || !connector.winch->paths[end]) {
    throw std::invalid_argument("the connector " + connector.name + " has no winch there");
  }
  Mechanism mechanism(world);
  TensionSystem system(mechanism);
  std::vector<double> state, right, tension;
  mechanism.load(world, state);
  PulleyFriction friction;
  friction.rebuild(mechanism);
  if (friction.any()) friction.decide(mechanism, system, world.time, state);
  mechanism.update(world.time, state.data());
  mechanism.right_side(right);
  system.assemble(mechanism);
  system.solve(right, tension);
  std::vector<double> slope(state.size());
  mechanism.differentiate(state.data(), tension.data(), slope.data());
  std::vector<Vec3> acceleration;
  for (std::size_t i = 0; i < mechanism.points(); ++i) {
    acceleration.emplace_back(Eigen::Map<const Vec3>(&slope[mechanism.velocity(i)]));
  }
  std::size_t first = 0;
  for (const Connector& other : world.connectors) {
    for (const Hold& hold : other.holds) {  // whose slopes are zero
      acceleration[first + hold.particle] = hold_motion(world, hold.to, world.time).acceleration;
    }
    first += other.particles();
  }
  return mechanism.drum_force(index, end, state.data(), tension.data(), acceleration);
}

namespace {

constexpr int kIterations = 20;
constexpr double kRounding = 1e-14;  // m: rounding of positions of about a metre

}  // namespace

void Projection::rebuild(const Mechanism& mechanism) {
  system_.rebuild(mechanism);
  multiplier_.reserve(mechanism.row_room());
  multiplier_.resize(mechanism.unknowns());
  right_.resize(mechanism.pulleys() > 0 ? mechanism.unknowns() : 0);
}

/// `rows`, and zero for each pulley.
const std::vector<double>& Projection::right_side(const std::vector<double>& rows) {
  if (right_.empty()) return rows;
  std::ranges::copy(rows, right_.begin());
  return right_;
}

Projection::Left Projection::lengths(Mechanism& mechanism, double time,
                                     std::vector<double>& state) {
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    Eigen::Map<Eigen::Vector4d>(&state[mechanism.pose(b) + 3]).normalize();
  }
  mechanism.update(time, state.data());
  if (multiplier_.empty()) return {};
  Left left;
  for (int i = 0;; ++i) {
    const double before = left.violation;
    const auto& violation = mechanism.violation();
    const auto worst =
        std::ranges::max_element(violation, {}, [](double x) { return std::abs(x); });
    left = {std::abs(*worst), static_cast<std::size_t>(worst - violation.begin())};
    const bool settled = i > 0 && left.violation < kKept && left.violation > before / 2;
    if (!(left.violation >= kRounding) || settled || i == kIterations) return left;
    check_stop();
    system_.assemble(mechanism);
    system_.solve(right_side(violation), multiplier_);
    mechanism.move(multiplier_.data(), state.data());
    mechanism.update(time, state.data());
  }
}

void Projection::rates(Mechanism& mechanism, double time, std::vector<double>& state) {
  mechanism.update(time, state.data());
  if (multiplier_.empty()) return;
  system_.assemble(mechanism);
  system_.solve(right_side(mechanism.rate()), multiplier_);
  mechanism.push(multiplier_.data(), state.data());
  mechanism.place(time, state.data());
}

bool restore_lengths(World& world) {
  Mechanism mechanism(world);
  Projection projection(mechanism);
  std::vector<double> state;
  mechanism.load(world, state);
  if (!(projection.lengths(mechanism, world.time, state).violation <= Projection::kKept))
    return false;
  mechanism.store(state, world.time, world);
  return true;
}

bool stretches(const World& world) {
  constexpr double kRelative = 1e-13;
  for (const Connector& connector : world.connectors) {
    const std::vector<Vec3>&position = connector.position, &velocity = connector.velocity;
    double speed = 0;  // squared, of the particle before
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      const double last = std::exchange(speed, velocity[i].squaredNorm());
      if (i == 0) continue;
      const Vec3 apart = position[i] - position[i - 1];
      const double stretch = apart.dot(velocity[i] - velocity[i - 1]);
      const double most = kRelative * kRelative * std::max(last, speed) * apart.squaredNorm();
      if (stretch * stretch > most) return true;
    }
  }
  return false;
}

void VelocityProjection::stop(World& world) {
  mechanism_.rebuild(world);
  projection_.rebuild(mechanism_);
  state_.reserve(mechanism_.state_room());
  mechanism_.load(world, state_);
  projection_.rates(mechanism_, world.time, state_);
  mechanism_.store(state_, world.time, world);
}

namespace {

using Slip = Mechanism::Slip;

/// How far (share of both tensions) the larger one is from sliding: below zero it slides.
double from_sliding(const Mechanism::Pull& pull) {
  const double sum = std::abs(pull.before) + std::abs(pull.behind);
  const double forwards = pull.ratio * pull.before - pull.behind;
  const double backwards = pull.ratio * pull.behind - pull.before;
  return sum > 0 ? std::min(forwards, backwards) / sum : 0;
}

/// How far both are from pushing.
double from_pushing(const Mechanism::Pull& pull) {
  const double sum = std::abs(pull.before) + std::abs(pull.behind);
  return sum > 0 ? std::max(pull.before, pull.behind) / sum : 0;
}

}  // namespace

void PulleyFriction::rebuild(const Mechanism& mechanism) {
  any_ = false;
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) any_ = any_ || mechanism.has_friction(p);
  right_.reserve(mechanism.row_room());
  tension_.reserve(mechanism.row_room());
  right_.resize(mechanism.unknowns());
  tension_.resize(mechanism.unknowns());
}

void PulleyFriction::solve(Mechanism& mechanism, TensionSystem& system, double time,
                           std::vector<double>& state) {
  mechanism.update(time, state.data());
  mechanism.right_side(right_);
  system.assemble(mechanism);
  system.solve(right_, tension_);
}

void PulleyFriction::decide(Mechanism& mechanism, TensionSystem& system, double time,
                            std::vector<double>& state) {
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    if (!mechanism.has_friction(p)) continue;
    double& speed = state[mechanism.speed(p)];
    if (std::abs(speed) <= kNear) speed = 0;
    mechanism.set_slip(p, speed > 0 ? Slip::forwards : speed < 0 ? Slip::backwards : Slip::stick);
  }
  // Pulleys change one after another: each changes the tensions at others. Between two that stay,
  // the tension of rope without mass is undetermined: one of the two is left at its limit.
  constexpr double kMost = 2;  // beyond all shares
  for (std::size_t change = 0; change < 4 * mechanism.pulleys(); ++change) {
    solve(mechanism, system, time, state);
    double worst = -kNear;
    std::size_t which = mechanism.pulleys();
    Slip now = Slip::stick;
    const auto consider = [&](double distance, std::size_t pulley, Slip slip) {
      if (!(distance < worst)) return;
      worst = distance;
      which = pulley;
      now = slip;
    };
    for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
      const Slip slip = mechanism.slip(p);
      if (!mechanism.has_friction(p)) continue;
      const Mechanism::Pull pull = mechanism.pull_at(p, tension_.data());
      const double speed = state[mechanism.speed(p)];
      const double goes = speed != 0 ? speed : tension_[mechanism.rows().size() + p];
      const double ahead = slip == Slip::forwards ? goes : -goes;
      if (slip == Slip::free) {
        consider(-from_pushing(pull), p, goes > 0 ? Slip::forwards : Slip::backwards);
      } else if (from_pushing(pull) < 0) {
        consider(from_pushing(pull), p, Slip::free);
      } else if (slip != Slip::stick && ahead < -kNear) {
        consider(-kMost, p, Slip::stick);  // it began to slide before others did
      } else if (slip == Slip::stick) {
        consider(from_sliding(pull), p,
                 pull.behind > pull.before ? Slip::forwards : Slip::backwards);
      }
    }
    if (which == mechanism.pulleys()) return;
    mechanism.set_slip(which, now);
  }
}

double PulleyFriction::distance(Mechanism& mechanism, TensionSystem& system, double time,
                                std::vector<double>& state) {
  solve(mechanism, system, time, state);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    if (!mechanism.has_friction(p)) continue;
    const Mechanism::Pull pull = mechanism.pull_at(p, tension_.data());
    const double speed = state[mechanism.speed(p)];
    switch (mechanism.slip(p)) {
      case Slip::free:
        least = std::min(least, -from_pushing(pull));
        break;
      case Slip::stick:
        least = std::min({least, from_sliding(pull), from_pushing(pull)});
        break;
      case Slip::forwards:
        least = std::min({least, speed, from_pushing(pull)});
        break;
      case Slip::backwards:
        least = std::min({least, -speed, from_pushing(pull)});
        break;
    }
  }
  return least;
}

double PulleyFriction::share(double before, double behind) {
  constexpr double kLeast = 0.01;
  if (!(before > 0)) return 0.5;
  return std::clamp(before / (before - behind), kLeast, 1 - kLeast);
}

}  // namespace taut
