#include "sim/methods/direct/system/elastic_system.h"

#include <algorithm>
#include <cmath>

#include "sim/material/elements.h"
#include "sim/topology/components.h"

namespace taut::direct {
namespace {

using MapVec = Eigen::Map<Vec3>;
using ConstMapVec = Eigen::Map<const Vec3>;

constexpr int kProjections = 8;        // Newton steps back to the lengths, at most
constexpr double kRoundedOff = 4e-15;  // of the length: what is left of a violation
constexpr double kSingular = 1e-12;    // of what a pivot was made from: below it is rounding

ConstMapVec at(const double* values, std::size_t particle) {
  return ConstMapVec(values + 3 * particle);
}

}  // namespace

void ElasticSystem::rebuild(const World& world) {
  world_ = &world;
  const Connector& connector = world.connectors[0];
  const std::size_t n = connector.particles(), links = connector.links();
  material_.rebuild(world, n);
  gravity_ = world.gravity;
  length_ = connector.length;
  mass_ = connector.particle_mass;
  held_.assign(n, 0);
  for (const Hold& hold : connector.holds) held_[hold.particle] = 1;
  rest_ = connector.rest;
  compliance_.assign(links, 0.0);
  relaxation_.assign(links, 0.0);
  dead_.assign(links, 0);
  has_rigid_ = !connector.stretches();
  for (std::size_t k = 0; k < links; ++k) {
    dead_[k] = held_[k] && held_[k + 1];
    const Section& section = connector.sections[k];
    if (has_rigid_) continue;
    compliance_[k] = rest_[k] / section.axial_stiffness;
    relaxation_[k] = section.axial_damping / section.axial_stiffness;
  }
  force_.resize(n);
  stiffness_.resize(size() * (kHalf + 1));
  damped_ = !material_.drags().empty() ||
            std::ranges::any_of(material_.bends(),
                                [](const material::BendElement& bend) { return bend.damping > 0; });
  damping_.assign(damped_ ? stiffness_.size() : 0, 0.0);
  direction_.resize(links);
  led_.resize(links);
  for (auto* workspace : {&diagonal_, &sub_diagonal_, &impulse_, &factor_}) {
    workspace->resize(links);
  }
  rebuild_twist();
}

void ElasticSystem::place(double time, double* x, double* v) {
  for (const Hold& hold : world_->connectors[0].holds) {
    const PointMotion motion = hold_motion(*world_, hold.to, time);
    MapVec(x + 3 * hold.particle) = motion.position;
    MapVec(v + 3 * hold.particle) = motion.velocity;
  }
  material_.place(*world_, time);
}

void ElasticSystem::find_tensions(const double* x, const double* v, double* tensions) const {
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    if (is_rigid(k) || dead_[k]) continue;
    const Vec3 edge = at(x, k + 1) - at(x, k);
    const double length = edge.norm();
    const double faster = edge.dot(at(v, k + 1) - at(v, k)) / length;
    tensions[4 * (k + 1) + 3] = (length - rest_[k] + relaxation_[k] * faster) / compliance_[k];
  }
}

void ElasticSystem::residual(const double* x, const double* v, const double* acceleration,
                             const double* unknowns, double* left) {
  std::ranges::fill(force_, Vec3::Zero());
  material_.add_bends(x, v, force_);
  material_.add_drag(x, v, force_);
  material_.add_twists(x, v, force_);
  left[3] = 0;
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    const std::size_t row = 4 * (k + 1) + 3;
    const Vec3 edge = at(x, k + 1) - at(x, k);
    const double length = edge.norm(), tension = unknowns[row];
    const Vec3 unit = edge / length;
    if (dead_[k]) {
      left[row] = 0;
      continue;
    }
    force_[k] += tension * unit;
    force_[k + 1] -= tension * unit;
    const double stretched = length - rest_[k] + relaxation_[k] * unit.dot(at(v, k + 1) - at(v, k));
    left[row] = compliance_[k] * tension - stretched;
  }
  for (std::size_t i = 0; i < particles(); ++i) {
    MapVec row(left + 4 * i);
    if (held_[i]) {
      row.setZero();
    } else {
      row = mass_[i] * (gravity_ - at(acceleration, i)) + force_[i];
    }
  }
}

void ElasticSystem::add_block(std::size_t row, std::size_t column, const Mat3& block, Band& band) {
  if (held_[row] || held_[column]) return;
  for (std::size_t r = 0; r < 3; ++r) {
    double* entries = &band[(4 * row + r) * (kHalf + 1)] + kHalf + 4 * column - (4 * row + r);
    const std::size_t end = row == column ? r + 1 : 3;
    for (std::size_t c = 0; c < end; ++c) {
      entries[c] += block(static_cast<int>(r), static_cast<int>(c));
    }
  }
}

/// The terms that depend on the edge from particle a to b alone.
void ElasticSystem::add_edge(std::uint32_t a, std::uint32_t b, const Mat3& block, Band& band) {
  add_block(a, a, block, band);
  add_block(b, b, block, band);
  add_block(b, a, -block, band);
}

void ElasticSystem::add_bend(const material::BendElement& bend, const Mat3& h00, const Mat3& h01,
                             const Mat3& h11, Band& band) {
  if (!bend.clamped_before()) add_edge(bend.a, bend.b, h00, band);
  if (!bend.clamped_behind()) add_edge(bend.b, bend.c, h11, band);
  if (bend.clamped_before() || bend.clamped_behind()) return;
  // e0 = b - a, e1 = c - b; blocks below the diagonal.
  const Mat3 h10 = h01.transpose();
  add_block(bend.b, bend.b, -(h01 + h10), band);
  add_block(bend.b, bend.a, h10, band);
  add_block(bend.c, bend.b, h10, band);
  add_block(bend.c, bend.a, -h10, band);
}

void ElasticSystem::differentiate(const double* x, const double* v, const double* unknowns) {
  std::ranges::fill(stiffness_, 0.0);
  std::ranges::fill(damping_, 0.0);
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    if (dead_[k]) continue;
    const std::size_t row = 4 * (k + 1) + 3;
    const Vec3 edge = at(x, k + 1) - at(x, k);
    const double length = edge.norm();
    const Vec3 unit = edge / length;
    add_edge(static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k + 1),
             unknowns[row] / length * (Mat3::Identity() - unit * unit.transpose()), stiffness_);
    double* entries = &stiffness_[row * (kHalf + 1)] + kHalf - row;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!held_[k]) entries[4 * k + c] = -unit[static_cast<int>(c)];
      if (!held_[k + 1]) entries[4 * (k + 1) + c] = unit[static_cast<int>(c)];
    }
  }
  Vec3 e0, e1;
  for (const material::BendElement& bend : material_.bends()) {
    material_.edges(bend, x, e0, e1);
    const material::Bend shape(e0, e1, bend.rest);
    const material::Bend::Stiffness second = shape.stiffness(bend.stiffness);
    add_bend(bend, second.e0_e0, second.e0_e1, second.e1_e1, stiffness_);
    if (bend.damping == 0) continue;
    const material::Bend::Stiffness damped = shape.damping(bend.damping);
    add_bend(bend, damped.e0_e0, damped.e0_e1, damped.e1_e1, damping_);
  }
  for (const material::DragElement& link : material_.drags()) {
    const Vec3 speed = (at(v, link.a) + at(v, link.b)) / 2 - material_.wind();
    const Mat3 slope = material::drag_slope(at(x, link.b) - at(x, link.a), speed,
                                            link.density_area(), link.across, link.along) /
                       4;
    add_block(link.a, link.a, slope, damping_);
    add_block(link.b, link.b, slope, damping_);
    add_block(link.b, link.a, slope, damping_);
  }
  differentiate_twist(x, v);
}

template <class Scalar>
void ElasticSystem::assemble(Scalar rate, BandLdlt<Scalar, kHalf>& matrix) const {
  constexpr std::size_t width = kHalf + 1;
  Scalar* to = matrix.row(0);
  for (std::size_t i = 0; i < stiffness_.size(); ++i) to[i] = stiffness_[i] * Scalar{1};
  for (std::size_t i = 0; i < damping_.size(); ++i) to[i] = to[i] + damping_[i] * rate;
  const Scalar squared = rate * rate;
  for (std::size_t i = 0; i < particles(); ++i) {
    for (std::size_t r = 4 * i; r < 4 * i + 3; ++r) {
      Scalar& diagonal = to[r * width + kHalf];
      diagonal = held_[i] ? Scalar{1} : diagonal + mass_[i] * squared;
    }
    Scalar& link = to[(4 * i + 3) * width + kHalf];
    if (i == 0 || dead_[i - 1]) {
      link = Scalar{1};
    } else {
      link = -compliance_[i - 1] * inverse(Scalar{1} + relaxation_[i - 1] * rate);
    }
  }
}

template <class Scalar>
void ElasticSystem::scale_links(Scalar rate, Scalar* right) const {
  if (has_rigid_) return;
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    Scalar& link = right[4 * (k + 1) + 3];
    link = link * inverse(Scalar{1} + relaxation_[k] * rate);
  }
}

template void ElasticSystem::assemble(double, BandLdlt<double, kHalf>&) const;
template void ElasticSystem::assemble(Complex, BandLdlt<Complex, kHalf>&) const;
template void ElasticSystem::scale_links(double, double*) const;
template void ElasticSystem::scale_links(Complex, Complex*) const;

void ElasticSystem::add_damping(const double* by, double* to) const {
  add_twist_damping(by, to);
  for (std::size_t row = 0; row < (damped_ ? size() : 0); ++row) {
    const double* entries = &damping_[row * (kHalf + 1)];
    for (std::size_t c = row < kHalf ? kHalf - row : 0; c <= kHalf; ++c) {
      const std::size_t column = row + c - kHalf;
      to[row] += entries[c] * by[column];
      if (column != row) to[column] += entries[c] * by[row];
    }
  }
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    if (relaxation_[k] == 0 || dead_[k]) continue;
    const std::size_t row = 4 * (k + 1) + 3;
    const double* entries = &stiffness_[row * (kHalf + 1)] + kHalf - row;
    double faster = 0;
    for (std::size_t u = 4 * k; u < row; ++u) faster += u % 4 == 3 ? 0 : entries[u] * by[u];
    to[row] += relaxation_[k] * faster;
  }
}

/// The directions of the links, and the system of those that are `led`.
void ElasticSystem::fill_directions(const double* x) {
  const auto inverse_mass = [&](std::size_t i) { return held_[i] ? 0.0 : 1 / mass_[i]; };
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    direction_[k] = (at(x, k + 1) - at(x, k)).normalized();
    diagonal_[k] = led_[k] ? inverse_mass(k) + inverse_mass(k + 1) : 1;
    const bool coupled = k > 0 && led_[k] && led_[k - 1];
    sub_diagonal_[k] = coupled ? -inverse_mass(k) * direction_[k].dot(direction_[k - 1]) : 0;
  }
}

/// Solves for the links' impulses that part their ends by `right`: a tridiagonal system.
void ElasticSystem::solve_links(double* right) {
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    const double before = k > 0 ? sub_diagonal_[k] / factor_[k - 1] : 0;
    factor_[k] = diagonal_[k] - before * sub_diagonal_[k];
    // A link that others determine already, as in a straight rod between two holds, pulls nothing.
    if (!(factor_[k] > kSingular * diagonal_[k])) factor_[k] = INFINITY;
    if (k > 0) right[k] -= before * right[k - 1];
  }
  for (std::size_t k = rest_.size(); k-- > 0;) {
    if (k + 1 < rest_.size()) right[k] -= sub_diagonal_[k + 1] * right[k + 1];
    right[k] /= factor_[k];
  }
}

bool ElasticSystem::restore_lengths(double h, const double* tensions, double* x) {
  bool any = false;
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    const double inverse_mass =
        (held_[k] ? 0 : 1 / mass_[k]) + (held_[k + 1] ? 0 : 1 / mass_[k + 1]);
    led_[k] = relaxation_[k] == 0 && compliance_[k] < h * h * inverse_mass;
    if (compliance_[k] == 0 && !dead_[k]) led_[k] = 1;
    any = any || led_[k];
  }
  if (!any) return true;
  const auto move = [&](std::size_t i, const Vec3& by) {
    if (!held_[i]) MapVec(x + 3 * i) += by / mass_[i];
  };
  for (int newton = 0; newton < kProjections; ++newton) {
    fill_directions(x);
    double worst = 0;
    for (std::size_t k = 0; k < rest_.size(); ++k) {
      const double length = rest_[k] + compliance_[k] * tensions[4 * (k + 1) + 3];
      impulse_[k] = led_[k] ? (at(x, k + 1) - at(x, k)).norm() - length : 0;
      worst = std::max(worst, std::abs(impulse_[k]));
    }
    if (worst <= kRoundedOff * length_) return true;
    if (!(worst < length_)) return false;
    solve_links(impulse_.data());
    for (std::size_t k = 0; k < rest_.size(); ++k) {
      move(k, impulse_[k] * direction_[k]);
      move(k + 1, -impulse_[k] * direction_[k]);
    }
  }
  return true;
}

void ElasticSystem::stop_stretch(const double* x, double* v) {
  if (!has_rigid_) return;
  for (std::size_t k = 0; k < rest_.size(); ++k) led_[k] = !dead_[k];
  fill_directions(x);
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    impulse_[k] = led_[k] ? direction_[k].dot(at(v, k + 1) - at(v, k)) : 0;
  }
  solve_links(impulse_.data());
  for (std::size_t k = 0; k < rest_.size(); ++k) {
    const Vec3 by = impulse_[k] * direction_[k];
    if (!held_[k]) MapVec(v + 3 * k) += by / mass_[k];
    if (!held_[k + 1]) MapVec(v + 3 * (k + 1)) -= by / mass_[k + 1];
  }
}

// The terms of twist in the matrices of ElasticSystem.

/// Where the connector's frame is carried from one edge to the next: at each particle.
void ElasticSystem::rebuild_twist() {
  twist_slope_.clear();
  carries_.clear();
  if (material_.twists().empty()) return;
  const material::TwistElement& rod = material_.twists().front();
  twist_slope_.assign(size(), 0.0);
  carries_.push_back({.a = 0, .b = 0, .c = 1, .clamp = rod.from});
  for (std::uint32_t i = 1; i < rod.links; ++i)
    carries_.push_back({.a = i - 1, .b = i, .c = i + 1});
  carries_.push_back({.a = rod.links - 1, .b = rod.links, .c = rod.links, .clamp = rod.to});
}

/// The moment times the second derivatives of the twist, and its first derivatives.
void ElasticSystem::differentiate_twist(const double* x, const double* v) {
  if (carries_.empty()) return;
  const material::TwistElement& rod = material_.twists().front();
  double moment = rod.stiffness * material_.twist(rod, x);
  if (rod.damping > 0) moment += rod.damping * material_.twist_rate(rod, x, v);
  Vec3 e0, e1;
  for (const material::BendElement& at : carries_) {
    material_.edges(at, x, e0, e1);
    const material::Bend::Stiffness second = material::Carry(e0, e1).second();
    add_bend(at, moment * second.e0_e0, moment * second.e0_e1, moment * second.e1_e1, stiffness_);
  }
  material_.twist_slope(rod, x, force_);
  for (std::size_t i = 0; i < particles(); ++i) {
    if (held_[i]) continue;
    for (std::size_t c = 0; c < 3; ++c) twist_slope_[4 * i + c] = force_[i][static_cast<int>(c)];
  }
}

void ElasticSystem::add_twist_damping(const double* by, double* to) const {
  if (carries_.empty() || material_.twists().front().damping == 0) return;
  double rate = 0;
  for (std::size_t u = 0; u < size(); ++u) rate += twist_slope_[u] * by[u];
  const double moment = material_.twists().front().damping * rate;
  for (std::size_t u = 0; u < size(); ++u) to[u] += moment * twist_slope_[u];
}

double ElasticSystem::end_turn(const double* x) const {
  return carries_.empty() ? 0 : material_.turned(material_.twists().front(), x);
}

double ElasticSystem::followed_turn() const {
  return carries_.empty() ? 0 : material_.twists().front().since;
}

}  // namespace taut::direct
