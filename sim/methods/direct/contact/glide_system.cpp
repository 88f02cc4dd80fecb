#include "sim/methods/direct/contact/glide_system.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

/// The share of a step's impulses that makes its mean velocities.
constexpr double kMean = 0.5;
/// A row whose pull moves its ends by less than this share of what others would moves nothing.
constexpr double kNoShare = 1e-6;
constexpr std::uint32_t kNoPoint = UINT32_MAX;

/// How a place of a body moves with what pulls another that it carries with it, or the same.
Mat3 mobility(const Mechanism& mechanism, const contact::BodyMobility* bodies, std::uint32_t body,
              const Vec3& arm, std::uint32_t pulled, const Vec3& pulled_arm) {
  if (bodies) return contact::mobility(bodies->between(body, pulled), arm, pulled_arm);
  const auto& own = mechanism.bodies()[body];
  return own.inverse_mass * Mat3::Identity() -
         cross_matrix(arm) * own.world_inverse * cross_matrix(pulled_arm);
}

}  // namespace

void GlideSystem::rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together) {
  together_.assign(together.begin(), together.end());
  if (together.empty()) {
    together_.resize(mechanism.bodies().size());
    std::iota(together_.begin(), together_.end(), 0);
  }
  body_point_.assign(mechanism.points(), kNoPoint);
  for (std::size_t i = 0; i < mechanism.body_points().size(); ++i) {
    body_point_[mechanism.body_points()[i].point] = small(i);
  }
  arrange(mechanism, {});
}

/// Numbers the unknowns.
void GlideSystem::arrange(const Mechanism& mechanism, const Terms& terms) {
  const auto& rows = mechanism.rows();
  first_.assign(mechanism.points(), 0);
  row_.assign(rows.size(), 0);
  touch_.assign(terms.touches.size(), 0);
  bead_.assign(terms.beads.size(), 0);
  size_ = half_ = 0;
  std::size_t r = 0, t = 0, b = 0;
  for (std::size_t p = 0; p < first_.size(); ++p) {
    first_[p] = size_;
    size_ += 3;
    for (; t < touch_.size() && terms.touches[t].first == p; ++t) {
      touch_[t] = size_;
      size_ += 3;
    }
    for (; b < bead_.size() && terms.beads[b].point == p; ++b) {
      bead_[b] = size_;
      size_ += 3;
      half_ = std::max(half_, size_ - 1 - first_[p]);
    }
    for (; r < rows.size() && rows[r].a == p; ++r) row_[r] = size_++;
  }
  // Neighbours' velocities couple.
  for (const Row& row : rows) half_ = std::max(half_, first_[row.b] + 2 - first_[row.a]);
}

void GlideSystem::assemble(const Mechanism& mechanism, const Terms& terms) {
  const bool touches = !terms.touches.empty() || !terms.beads.empty();
  if (touches || !touch_.empty() || !bead_.empty()) arrange(mechanism, terms);
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
  for (std::size_t b = 0; b < bead_.size(); ++b) add_bead(mechanism, terms, b);
  band_.factor();
  find_border(mechanism, terms);
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

void GlideSystem::add_bead(const Mechanism& mechanism, const Terms& terms, std::size_t b) {
  const BeadTouch& at = terms.beads[b];
  const std::size_t point = first_[at.point], impulse = bead_[b];
  add(point, impulse, -terms.mobility[at.point]);
  const Mat3 changes = at.derivative - Mat3::Identity();
  add(impulse, point, changes + terms.h * at.bend);
  // The body gives way.
  const Mat3 gives = mobility(mechanism, terms.bodies, at.body, at.arm, at.body, at.arm);
  add(impulse, impulse, changes * gives - at.mobility * at.derivative);
}

/// What couples bodies beyond the band: pulls at one that has several, or at those which may touch
/// each other.
void GlideSystem::find_border(const Mechanism& mechanism, const Terms& terms) {
  border_.clear();
  receivers_.clear();
  if (together_.empty()) return;
  const auto& ends = mechanism.row_ends();
  const auto& points = mechanism.body_points();
  count_.assign(together_.size(), 0);
  for (const auto& end : ends) ++count_[together_[points[end.body_point].body]];
  for (const BeadTouch& at : terms.beads) ++count_[together_[at.body]];
  const auto is_coupled = [&](std::uint32_t body) { return count_[together_[body]] > 1; };
  const auto add_three = [&](std::uint32_t body, std::size_t unknown, std::size_t own,
                             const Vec3& arm, double share) {
    for (int axis = 0; axis < 3; ++axis) {
      border_.push_back({.body = body,
                         .unknown = unknown + static_cast<std::size_t>(axis),
                         .own = own,
                         .arm = arm,
                         .gives = share * Vec3::Unit(axis)});
    }
  };
  for (const auto& end : ends) {
    const auto& at = points[end.body_point];
    if (!is_coupled(at.body)) continue;
    border_.push_back({.body = at.body,
                       .unknown = row_[end.row],
                       .own = first_[at.point],
                       .arm = at.arm,
                       .gives = kMean * end.sign * terms.along[end.row]});
  }
  for (const auto& at : points) {
    if (!is_coupled(at.body)) continue;
    receivers_.push_back({.body = at.body,
                          .equation = first_[at.point],
                          .arm = at.arm,
                          .response = -Mat3::Identity()});
  }
  for (std::size_t t = 0; t < touch_.size(); ++t) {
    const LinkTouch& touch = terms.touches[t];
    for (const std::uint32_t end : {0u, 1u}) {
      const std::uint32_t point = body_point_[touch.first + end];
      if (point == kNoPoint || !is_coupled(points[point].body)) continue;
      add_three(points[point].body, touch_[t], first_[touch.first + end], points[point].arm,
                end == 0 ? 1 - touch.share : touch.share);
    }
  }
  for (std::size_t b = 0; b < bead_.size(); ++b) {
    const BeadTouch& at = terms.beads[b];
    if (!is_coupled(at.body)) continue;
    add_three(at.body, bead_[b], bead_[b], at.arm, -1);
    receivers_.push_back({.body = at.body,
                          .equation = bead_[b],
                          .arm = at.arm,
                          .response = Mat3::Identity() - at.derivative});
  }
}

void GlideSystem::add_bodies(const Mechanism& mechanism, const Terms& terms) {
  const std::size_t count = border_.size();
  columns_.assign(count * size_, 0);
  Eigen::MatrixXd system =
      Eigen::MatrixXd::Identity(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(count));
  for (std::size_t c = 0; c < count; ++c) {
    const Source& by = border_[c];
    const std::span column(&columns_[c * size_], size_);
    for (const Receiver& at : receivers_) {
      const bool meet = terms.bodies && terms.bodies->meet(at.body, by.body);
      if ((at.body != by.body && !meet) || at.equation == by.own) continue;
      const Mat3 coupled = mobility(mechanism, terms.bodies, at.body, at.arm, by.body, by.arm);
      const Vec3 moves = at.response * (coupled * by.gives);
      for (int i = 0; i < 3; ++i) column[at.equation + static_cast<std::size_t>(i)] = moves[i];
    }
    band_.solve(column);
    for (std::size_t k = 0; k < count; ++k) {
      system(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) +=
          column[border_[k].unknown];
    }
  }
  decomposed_.compute(system);
}

void GlideSystem::solve(std::span<Vec3> velocity, std::span<double> impulse, std::span<Vec3> given,
                        std::span<Vec3> by_beads) {
  values_.resize(size_);
  for (std::size_t p = 0; p < first_.size(); ++p) {
    for (int i = 0; i < 3; ++i) values_[first_[p] + static_cast<std::size_t>(i)] = velocity[p][i];
  }
  for (std::size_t r = 0; r < row_.size(); ++r) values_[row_[r]] = impulse[r];
  const auto each = [&](const auto& visit) {
    for (std::size_t t = 0; t < touch_.size(); ++t) visit(touch_[t], given[t]);
    for (std::size_t b = 0; b < bead_.size(); ++b) visit(bead_[b], by_beads[b]);
  };
  each([&](std::size_t at, const Vec3& value) {
    for (int i = 0; i < 3; ++i) values_[at + static_cast<std::size_t>(i)] = value[i];
  });
  band_.solve(values_);
  if (!border_.empty()) {
    found_.resize(static_cast<Eigen::Index>(border_.size()));
    for (std::size_t k = 0; k < border_.size(); ++k) {
      found_[static_cast<Eigen::Index>(k)] = values_[border_[k].unknown];
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
  each([&](std::size_t at, Vec3& value) {
    for (int i = 0; i < 3; ++i) value[i] = values_[at + static_cast<std::size_t>(i)];
  });
}

}  // namespace taut::direct
