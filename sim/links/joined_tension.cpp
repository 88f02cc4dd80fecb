#include "sim/links/joined_tension.h"

#include <algorithm>
#include <utility>

namespace taut {
namespace {

std::uint32_t narrow(std::size_t index) {
  return static_cast<std::uint32_t>(index);
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
    return narrow(rows_) +
           narrow(static_cast<std::size_t>(std::ranges::lower_bound(pairs, p) - pairs.begin()));
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
    const auto &g = ends[term.end], &h = ends[term.other];
    const auto &point = mechanism.body_points()[g.body_point],
               &other_point = mechanism.body_points()[h.body_point];
    const auto& body = mechanism.bodies()[point.body];
    const Vec3 pull = g.sign * direction[g.row], other = h.sign * direction[h.row];
    values_[term.value] +=
        term.times * (body.inverse_mass * pull.dot(other) +
                      point.arm.cross(pull).dot(body.world_inverse * other_point.arm.cross(other)));
  }
}

bool JoinedTension::solve(const std::vector<double>& right, std::vector<double>& x) {
  x.resize(rows_);
  ldlt_.factor(values_.data());
  ldlt_.solve(right.data(), x.data());
  return ldlt_.dependent() == 0;
}

}  // namespace taut
