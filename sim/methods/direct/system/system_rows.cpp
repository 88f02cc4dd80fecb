// Rows that border the tensions' system.
#include <algorithm>
#include <stdexcept>

#include "sim/methods/direct/system/system.h"

namespace taut::direct {

/// Finds the points of the rows and the links that meet there.
void System::place_rows(std::span<const ConstraintRow* const> rows) {
  rows_.clear();
  terms_.clear();
  if (rows.empty()) return;
  for (const ConstraintRow* row : rows) {
    if (floats_) throw std::invalid_argument("a row needs a component that something holds");
    rows_.push_back({.row = row, .first_term = terms_.size(), .value = {}});
    for (const ConstraintRow::Particle& particle : row->particles()) {
      terms_.push_back(term_of(particle));
    }
  }
  const auto count = static_cast<Eigen::Index>(rows_.size());
  row_gains_.resize(count, count);
  row_rights_.resize(count);
  row_responses_.resize(links_.count() * (rows_.size() + 1));
}

System::RowTerm System::term_of(const ConstraintRow::Particle& particle) const {
  std::size_t p = 0;
  for (const Span& span : spans_) {
    const SpanRange& range = span.range;
    if (range.connector == particle.connector && range.first <= particle.index &&
        particle.index <= range.last) {
      const std::size_t k =
          (span.reversed ? range.last - particle.index : particle.index - range.first) +
          (span.first_body_link == kNone ? 0 : 1);
      RowTerm term{.point = p + k};
      if (k == 0) term.end = span.first;
      if (k == span.links) term.end = span.last;
      if (k > 0) term.before = span.offset + k - 1;
      if (k < span.links) term.after = span.offset + k;
      if (term.end != kNone && ends_[term.end].body != kNone) {
        throw std::invalid_argument("a row speaks of particles, none of them on a free body");
      }
      term.inverse_mass = term.before == kNone ? measured_[term.after].inverse_mass_first
                                               : measured_[term.before].inverse_mass_second;
      return term;
    }
    p += span.links + 1;
  }
  throw std::invalid_argument("a row speaks of a particle that its component has not");
}

/// How the rows stand; points_ are up to date.
void System::evaluate_rows(double time) {
  for (Bordered& bordered : rows_) {
    const std::size_t count = bordered.row->particles().size();
    row_points_.resize(count);
    row_gradients_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
      row_points_[k] = points_[terms_[bordered.first_term + k].point];
    }
    bordered.value = bordered.row->evaluate(time, row_points_, row_gradients_);
    for (std::size_t k = 0; k < count; ++k) {
      terms_[bordered.first_term + k].gradient = row_gradients_[k];
    }
  }
}

/// By how much (m/s^2) the tensions T bring the particles of a row together along its gradient:
/// B'T, with B_i = w u_i . n for the link before a particle of inverse mass w, B_j = -w u_j . n for
/// the one behind.
template <typename Visit>
void System::each_entry(const double* q, const Bordered& bordered, Visit visit) const {
  for (std::size_t k = 0; k < bordered.row->particles().size(); ++k) {
    const RowTerm& term = terms_[bordered.first_term + k];
    const double w = term.inverse_mass;
    if (w == 0) continue;
    if (term.before != kNone) {
      const Vec3 u = links_.direction(q, term.before);
      visit(term.before, w * u.dot(term.gradient), u, w * term.gradient);
    }
    if (term.after != kNone) {
      const Vec3 u = links_.direction(q, term.after);
      visit(term.after, -w * u.dot(term.gradient), u, -w * term.gradient);
    }
  }
}

/// Solves A T = r + B y, C y - B'T = s for tensions T and multipliers y, r being the right side of
/// the links and s that of the rows: (C - B'A^-1 B) y = s + B'A^-1 r.
void System::solve_with_rows(const double* q) {
  const auto at = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  const std::size_t links = links_.count();
  const auto response = [&](std::size_t k) { return row_responses_.data() + k * links; };
  const auto pulled = [&](const Bordered& bordered) {
    double sum = 0;
    each_entry(q, bordered, [&](std::size_t link, double entry, const Vec3&, const Vec3&) {
      sum += entry * links_.tension(link);
    });
    return sum;
  };
  solve_tensions();
  for (std::size_t k = 0; k < rows_.size(); ++k)
    row_rights_[at(k)] = rows_[k].right + pulled(rows_[k]);
  double* without = response(rows_.size());
  std::ranges::copy(links_.unknowns(), without);
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    links_.clear_right();
    each_entry(q, rows_[c], [&](std::size_t link, double entry, const Vec3&, const Vec3&) {
      links_.add_right(link, entry);
    });
    solve_tensions();
    std::ranges::copy(links_.unknowns(), response(c));
    for (std::size_t r = 0; r < rows_.size(); ++r)
      row_gains_(at(r), at(c)) = mobility(r, c) - pulled(rows_[r]);
  }
  row_solver_.compute(row_gains_);
  const Eigen::VectorXd multipliers = row_solver_.solve(row_rights_);
  std::copy_n(without, links, links_.unknowns().begin());
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    rows_[k].multiplier = multipliers[at(k)];
    links_.add_response(response(k), multipliers[at(k)]);
  }
}

/// The response along one row's gradient to a unit force along another's, 1/kg.
double System::mobility(std::size_t a, std::size_t b) const {
  double sum = 0;
  for (std::size_t i = 0; i < rows_[a].row->particles().size(); ++i) {
    for (std::size_t j = 0; j < rows_[b].row->particles().size(); ++j) {
      const RowTerm &one = terms_[rows_[a].first_term + i],
                    &other = terms_[rows_[b].first_term + j];
      if (one.point == other.point) sum += one.inverse_mass * one.gradient.dot(other.gradient);
    }
  }
  return sum;
}

/// Leaves to the rows what of g'' no multiplier causes.
void System::lead_rows() {
  for (Bordered& bordered : rows_) {
    bordered.right = -bordered.value.velocity_term;
    for (std::size_t k = 0; k < bordered.row->particles().size(); ++k) {
      const RowTerm& term = terms_[bordered.first_term + k];
      Vec3 acceleration = world_->gravity;
      if (term.end != kNone) acceleration += ends_[term.end].free_acceleration;
      bordered.right -= term.gradient.dot(acceleration);
    }
  }
}

/// The rows' own forces on the particles.
void System::push_rows(const double* q, double* out) const {
  for (const Bordered& bordered : rows_) {
    each_entry(q, bordered, [&](std::size_t link, double, const Vec3& u, const Vec3& push) {
      links_.add(link, u, links_.inverse_rest(link) * bordered.multiplier * push, out);
    });
  }
}

}  // namespace taut::direct
