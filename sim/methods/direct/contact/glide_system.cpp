#include "sim/methods/direct/contact/glide_system.h"

#include <algorithm>

#include "sim/contact/row_system.h"
#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

/// The share of a step's impulses that makes its mean velocities.
constexpr double kMean = 0.5;
/// A row whose pull moves its ends by less than this share of what others would moves nothing.
constexpr double kNoShare = 1e-6;

/// How a body's point moves with a pull at another (or the same) of its points.
Mat3 mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& at,
              const Mechanism::BodyPoint& pulled) {
  const auto& body = mechanism.bodies()[at.body];
  return body.inverse_mass * Mat3::Identity() -
         cross_matrix(at.arm) * body.world_inverse * cross_matrix(pulled.arm);
}

}  // namespace

void GlideSystem::rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together) {
  arrange(mechanism, {});
  border_ = contact::ends_that_meet(mechanism, together);
  border_rows_.clear();
  for (const std::size_t end : border_) border_rows_.push_back(mechanism.row_ends()[end].row);
}

/// Numbers the unknowns.
void GlideSystem::arrange(const Mechanism& mechanism, std::span<const LinkTouch> touches) {
  const auto& rows = mechanism.rows();
  first_.assign(mechanism.points(), 0);
  row_.assign(rows.size(), 0);
  touch_.assign(touches.size(), 0);
  size_ = half_ = 0;
  std::size_t r = 0, t = 0;
  for (std::size_t p = 0; p < first_.size(); ++p) {
    first_[p] = size_;
    size_ += 3;
    for (; t < touches.size() && touches[t].first == p; ++t) {
      touch_[t] = size_;
      size_ += 3;
    }
    for (; r < rows.size() && rows[r].a == p; ++r) row_[r] = size_++;
  }
  // Neighbours' velocities couple.
  for (const Row& row : rows) half_ = std::max(half_, first_[row.b] + 2 - first_[row.a]);
}

void GlideSystem::assemble(const Mechanism& mechanism, const Terms& terms) {
  if (!terms.touches.empty() || !touch_.empty()) arrange(mechanism, terms.touches);
  band_.clear(size_, half_);
  for (std::size_t p = 0; p < first_.size(); ++p) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double bend = terms.h * terms.bend[p](static_cast<int>(i), static_cast<int>(k));
        band_.at(first_[p] + i, first_[p] + k) = (i == k ? 1.0 : 0.0) - bend;
      }
    }
  }
  for (std::size_t r = 0; r < row_.size(); ++r) add_row(mechanism, terms, r);
  for (std::size_t t = 0; t < touch_.size(); ++t) add_touch(terms, t);
  band_.factor();
  if (!border_.empty()) add_bodies(mechanism, terms);
}

void GlideSystem::add(std::size_t row, std::size_t column, const Mat3& block) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      band_.at(row + i, column + k) += block(static_cast<int>(i), static_cast<int>(k));
    }
  }
}

void GlideSystem::add_touch(const Terms& terms, std::size_t t) {
  const LinkTouch& at = terms.touches[t];
  const std::size_t a = first_[at.first], b = first_[at.first + 1], impulse = touch_[t];
  const Mat3 &mobility_a = terms.mobility[at.first], &mobility_b = terms.mobility[at.first + 1];
  const Vec3 slope_a = terms.h * at.slope_first, slope_b = terms.h * at.slope_next;
  const double left = 1 - at.share;
  // What is given goes to both points by the lever rule, and to other shares as the touch moves.
  add(a, impulse, -left * mobility_a);
  add(b, impulse, -at.share * mobility_b);
  const Vec3 moves_a = mobility_a * at.given, moves_b = mobility_b * at.given;
  add(a, a, moves_a * slope_a.transpose());
  add(a, b, moves_a * slope_b.transpose());
  add(b, a, -moves_b * slope_a.transpose());
  add(b, b, -moves_b * slope_b.transpose());
  const Mat3 changes = at.derivative - Mat3::Identity();
  const Vec3 shifts = changes * at.apart;
  add(impulse, a, left * changes + terms.h * at.bend_first + shifts * slope_a.transpose());
  add(impulse, b, at.share * changes + terms.h * at.bend_next + shifts * slope_b.transpose());
  add(impulse, impulse, -at.mobility * at.derivative);
}

void GlideSystem::add_row(const Mechanism& mechanism, const Terms& terms, std::size_t r) {
  const Row& row = mechanism.rows()[r];
  const std::size_t a = first_[row.a], b = first_[row.b], pull = row_[r];
  const Mat3 &mobility_a = terms.mobility[row.a], &mobility_b = terms.mobility[row.b];
  const Vec3 from_a = kMean * mobility_a * terms.along[r],
             from_b = kMean * mobility_b * terms.along[r];
  const Mat3 turn = kMean * terms.h * terms.turn[r];
  const Mat3 turn_a = mobility_a * turn, turn_b = mobility_b * turn;
  const auto largest = [](const auto& matrix) { return matrix.cwiseAbs().maxCoeff(); };
  const bool acts = largest(from_a) > kNoShare * largest(mobility_a) ||
                    largest(from_b) > kNoShare * largest(mobility_b);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<int>(i);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto by = static_cast<int>(k);
      band_.at(a + i, a + k) += turn_a(at, by);
      band_.at(a + i, b + k) -= turn_a(at, by);
      band_.at(b + i, b + k) += turn_b(at, by);
      band_.at(b + i, a + k) -= turn_b(at, by);
    }
    if (!acts) continue;
    band_.at(a + i, pull) = -from_a[at];
    band_.at(b + i, pull) = from_b[at];
    band_.at(pull, a + i) = -terms.to[r][at];
    band_.at(pull, b + i) = terms.to[r][at];
  }
}

void GlideSystem::add_bodies(const Mechanism& mechanism, const Terms& terms) {
  const auto& ends = mechanism.row_ends();
  const std::size_t count = border_.size();
  columns_.assign(count * size_, 0);
  Eigen::MatrixXd system =
      Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  for (std::size_t c = 0; c < count; ++c) {
    const auto& end = ends[border_[c]];
    const auto& pulled = mechanism.body_points()[end.body_point];
    const std::span column(&columns_[c * size_], size_);
    for (const std::size_t e : border_) {
      const auto& at = mechanism.body_points()[ends[e].body_point];
      const bool meet = terms.bodies && terms.bodies->meet(at.body, pulled.body);
      if ((at.body != pulled.body && !meet) || at.point == pulled.point) continue;
      const Mat3 coupled =
          !terms.bodies
              ? mobility(mechanism, at, pulled)
              : contact::mobility(terms.bodies->between(at.body, pulled.body), at.arm, pulled.arm);
      const Vec3 moves = -kMean * end.sign * (coupled * terms.along[end.row]);
      for (int i = 0; i < 3; ++i) column[first_[at.point] + static_cast<std::size_t>(i)] = moves[i];
    }
    band_.solve(column);
    for (std::size_t k = 0; k < count; ++k) {
      system(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) +=
          column[row_[border_rows_[k]]];
    }
  }
  decomposed_.compute(system);
}

void GlideSystem::solve(std::span<Vec3> velocity, std::span<double> impulse,
                        std::span<Vec3> given) {
  values_.resize(size_);
  for (std::size_t p = 0; p < first_.size(); ++p) {
    for (int i = 0; i < 3; ++i) values_[first_[p] + static_cast<std::size_t>(i)] = velocity[p][i];
  }
  for (std::size_t r = 0; r < row_.size(); ++r) values_[row_[r]] = impulse[r];
  for (std::size_t t = 0; t < touch_.size(); ++t) {
    for (int i = 0; i < 3; ++i) values_[touch_[t] + static_cast<std::size_t>(i)] = given[t][i];
  }
  band_.solve(values_);
  if (!border_.empty()) {
    found_.resize(static_cast<Eigen::Index>(border_.size()));
    for (std::size_t k = 0; k < border_.size(); ++k) {
      found_[static_cast<Eigen::Index>(k)] = values_[row_[border_rows_[k]]];
    }
    decomposed_.solve(found_, share_);
    for (std::size_t k = 0; k < border_.size(); ++k) {
      const double part = share_[static_cast<Eigen::Index>(k)];
      for (std::size_t i = 0; i < size_; ++i) values_[i] -= part * columns_[k * size_ + i];
    }
  }
  for (std::size_t p = 0; p < first_.size(); ++p) {
    for (int i = 0; i < 3; ++i) velocity[p][i] = values_[first_[p] + static_cast<std::size_t>(i)];
  }
  for (std::size_t r = 0; r < row_.size(); ++r) impulse[r] = values_[row_[r]];
  for (std::size_t t = 0; t < touch_.size(); ++t) {
    for (int i = 0; i < 3; ++i) given[t][i] = values_[touch_[t] + static_cast<std::size_t>(i)];
  }
}

}  // namespace taut::direct
