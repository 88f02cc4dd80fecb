#include "sim/contact/row_system.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr double kSingular = 1e-12;    // of a row's own mobility: a pivot below is rounding
constexpr double kNoMobility = 1e-12;  // of a particle's largest mobility: it has none

double or_nothing(double along, const Mat3& mobility) {
  return std::abs(along) > kNoMobility * mobility.lpNorm<Eigen::Infinity>() ? along : 0;
}

}  // namespace

std::vector<std::size_t> ends_that_meet(const Mechanism& mechanism,
                                        std::span<const std::uint32_t> together) {
  const auto& ends = mechanism.row_ends();
  const auto body = [&](const Mechanism::RowEnd& end) {
    const std::uint32_t own = mechanism.body_points()[end.body_point].body;
    return together.empty() ? own : together[own];
  };
  std::vector<std::size_t> count(mechanism.bodies().size()), found;
  for (const auto& end : ends) ++count[body(end)];
  for (std::size_t e = 0; e < ends.size(); ++e) {
    if (count[body(ends[e])] > 1) found.push_back(e);
  }
  return found;
}

void RowSystem::rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together) {
  const std::size_t rows = mechanism.rows().size();
  for (auto* array : {&diagonal_, &lower_, &upper_, &inverse_pivot_, &scale_}) {
    array->reserve(mechanism.row_room());
    array->assign(rows, 0);
  }
  border_ = ends_that_meet(mechanism, together);
  border_rows_.clear();
  for (const std::size_t end : border_) border_rows_.push_back(mechanism.row_ends()[end].row);
  const auto size = static_cast<Eigen::Index>(border_.size());
  columns_.assign(rows * border_.size(), 0);
  coupling_.resize(size, size);
  share_.resize(size);
}

void RowSystem::assemble(const Mechanism& mechanism, std::span<const Mat3> mobility,
                         std::span<const Vec3> left, std::span<const Vec3> right,
                         const BodyMobility* bodies) {
  const auto& rows = mechanism.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    const Vec3 from_a = mobility[row.a].transpose() * left[r];
    const Vec3 from_b = mobility[row.b].transpose() * left[r];
    const double at_a = or_nothing(from_a.dot(right[r]), mobility[row.a]);
    const double at_b = or_nothing(from_b.dot(right[r]), mobility[row.b]);
    scale_[r] = std::abs(at_a) + std::abs(at_b);
    diagonal_[r] = at_a + at_b;
    // Neighbours share a particle that the one's b and the other's a is.
    lower_[r] = r > 0 && rows[r - 1].b == row.a ? -from_a.dot(right[r - 1]) : 0;
    const bool followed = r + 1 < rows.size() && rows[r + 1].a == row.b;
    upper_[r] = followed ? -from_b.dot(right[r + 1]) : 0;
  }
  add_bodies(mechanism, left, right, bodies);
  eliminate();
  if (border_.empty()) return;
  const std::size_t count = rows.size();
  Eigen::MatrixXd system = Eigen::MatrixXd::Identity(coupling_.rows(), coupling_.cols());
  Eigen::MatrixXd response(coupling_.rows(), coupling_.cols());
  for (std::size_t k = 0; k < border_.size(); ++k) {
    check_stop();
    const std::span column(&columns_[k * count], count);
    std::ranges::fill(column, 0.0);
    column[border_rows_[k]] = 1;
    sweep(column);
    for (std::size_t i = 0; i < border_.size(); ++i) {
      response(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          column[border_rows_[i]];
    }
  }
  system += response * coupling_;
  decomposed_.compute(system);
}

void RowSystem::add_bodies(const Mechanism& mechanism, std::span<const Vec3> left,
                           std::span<const Vec3> right, const BodyMobility* bodies) {
  const auto& ends = mechanism.row_ends();
  const auto mobility = [&](const Mechanism::RowEnd& end, const Mechanism::RowEnd& other) {
    const auto& at = mechanism.body_points()[end.body_point];
    const auto& pulled = mechanism.body_points()[other.body_point];
    const auto& body = mechanism.bodies()[at.body];
    if (bodies) {
      const Mat3 coupled =
          contact::mobility(bodies->between(at.body, pulled.body), at.arm, pulled.arm);
      const double moves = left[end.row].dot(coupled * right[other.row]);
      return end.sign * other.sign * or_nothing(moves, Mat3(body.inverse_mass * Mat3::Identity()));
    }
    const Vec3 turn = at.arm.cross(left[end.row]);
    return end.sign * other.sign *
           (body.inverse_mass * left[end.row].dot(right[other.row]) +
            turn.dot(body.world_inverse * pulled.arm.cross(right[other.row])));
  };
  for (const auto& end : ends) {
    const double own = mobility(end, end);
    diagonal_[end.row] += own;
    scale_[end.row] += std::abs(own);
  }
  for (std::size_t i = 0; i < border_.size(); ++i) {
    for (std::size_t k = 0; k < border_.size(); ++k) {
      const auto &end = ends[border_[i]], &other = ends[border_[k]];
      const std::uint32_t moved = mechanism.body_points()[end.body_point].body;
      const std::uint32_t pulled = mechanism.body_points()[other.body_point].body;
      const bool same = moved == pulled || (bodies && bodies->meet(moved, pulled));
      coupling_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          i != k && same ? mobility(end, other) : 0;
    }
  }
}

void RowSystem::eliminate() {
  double last = 0;  // the inverse pivot before
  for (std::size_t r = 0; r < diagonal_.size(); ++r) {
    const double above = r > 0 ? upper_[r - 1] : 0;
    const double pivot = diagonal_[r] - lower_[r] * last * above;
    last = std::abs(pivot) > kSingular * scale_[r] ? 1 / pivot : 0;
    inverse_pivot_[r] = last;
  }
}

void RowSystem::sweep(std::span<double> x) const {
  for (std::size_t r = 0; r < x.size(); ++r) {
    const double before = r > 0 ? x[r - 1] : 0;
    x[r] = (x[r] - lower_[r] * before) * inverse_pivot_[r];
  }
  for (std::size_t r = x.size(); r-- > 1;) {
    x[r - 1] -= upper_[r - 1] * inverse_pivot_[r - 1] * x[r];
  }
}

void RowSystem::solve(std::span<double> x) const {
  sweep(x);
  if (border_.empty()) return;
  // A = T + E C E', T as swept: x = T^-1 b - T^-1 E C (I + E' T^-1 E C)^-1 E' T^-1 b.
  const std::size_t count = x.size();
  for (std::size_t k = 0; k < border_.size(); ++k) {
    share_[static_cast<Eigen::Index>(k)] = x[border_rows_[k]];
  }
  decomposed_.solve(share_, given_);
  share_.noalias() = coupling_ * given_;
  for (std::size_t k = 0; k < border_.size(); ++k) {
    const double part = share_[static_cast<Eigen::Index>(k)];
    for (std::size_t r = 0; r < count; ++r) x[r] -= part * columns_[k * count + r];
  }
}

}  // namespace taut::contact
