#include "sim/methods/direct/elastic.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "sim/links/mechanism.h"
#include "sim/material/elements.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/system/system.h"
#include "sim/motion/stop.h"
#include "sim/topology/components.h"

namespace taut::direct {
namespace {

constexpr double kRate = 3;           // 1/s, tolerances that the steps of a second may err in all
constexpr double kShare = 0.3;        // tolerances that a step may err
constexpr double kSolved = 1e-2;      // of that error: where Newton's method ends
constexpr double kExactly = 1e-13;    // of the length: the same with a fixed step
constexpr double kRoundings = 1e-13;  // of the length: no estimate says anything of less
constexpr double kFirstShare = 1e-2;  // of what falls through the tolerance
constexpr double kOrder = 4;          // of the error's estimate in a step

void copy_motion(const Connector& from, Connector& to) {
  to.position = from.position;
  to.velocity = from.velocity;
  to.end_turn = from.end_turn;
}

}  // namespace

void Elastic::rebuild(const World& world, std::size_t connector) {
  connector_ = connector;
  bodies_.clear();
  own_ = {};
  own_.gravity = world.gravity;
  own_.air = world.air;
  own_.connectors = {world.connectors[connector]};
  for (Hold& hold : own_.connectors[0].holds) {
    if (hold.to.kind != Attachment::Kind::body) continue;
    const auto known = std::ranges::find(bodies_, hold.to.body);
    const auto index = static_cast<std::size_t>(known - bodies_.begin());
    if (known == bodies_.end()) {
      bodies_.push_back(hold.to.body);
      own_.bodies.push_back(world.bodies[hold.to.body]);
    }
    hold.to.body = index;
  }
  step_.rebuild(own_);
  known_ = false;
}

void Elastic::advance(World& world, double until, Counters& counters) {
  counters_ = &counters;
  Connector &own = own_.connectors[0], &shown = world.connectors[connector_];
  if (!known_ || own_.time != world.time || own.position != shown.position ||
      own.velocity != shown.velocity) {
    copy_motion(shown, own);
    own_.time = world.time;
    step_.load(own_.time);
    controller_.start(own_.time);
    known_ = true;
  }
  controller_.follow(*this, until, counters);
  own_.time = until;
  step_.store(own_);
  copy_motion(own, shown);
}

double Elastic::allowed(double h) const {
  const double length = own_.connectors[0].length;
  const double share = std::min(kRate * options_.finer * h, kShare);
  return std::max(share * options_.asked(length) / std::pow(options_.finer, kOrder),
                  kRoundings * length);
}

/// The error (m) allowed to Newton's method: its error of places is one of velocities as well, over
/// the step, and those move the particles on.
double Elastic::left_open(double h) const {
  const double length = own_.connectors[0].length;
  const double step_share = std::min(1.0, h / velocity_time_of(length));
  const double exact = kExactly * length;
  return step_share * (options_.step > 0 ? exact : std::max(exact, kSolved * allowed(h)));
}

double Elastic::first_step() const {
  const double fall = std::max(own_.gravity.norm(), 1.0);
  return kFirstShare * std::sqrt(2 * options_.tolerance / fall) / options_.finer;
}

double Elastic::longest_step(double) {
  return kNever;
}

double Elastic::order() const {
  return kOrder;
}

bool Elastic::lands(double, double) const {
  return true;
}

Attempt Elastic::attempt(double time, double h, double) {
  const double limit = allowed(h);
  const std::uint64_t before = step_.iterations();
  const RadauStep::Result result = step_.attempt(time, h, left_open(h), limit);
  const std::uint64_t solves = step_.iterations() - before;
  counters_->solves += solves;
  counters_->cycles += static_cast<double>(solves + 1) * step_.cycles();
  return {result.converged, result.error, limit};
}

void Elastic::accept(double) {
  step_.accept();
}

void Elastic::give_up(double time) {
  step_.store(own_);
  Mechanism mechanism;
  mechanism.rebuild(own_);
  std::vector<double> state;
  mechanism.load(own_, state);
  throw no_step(own_, mechanism, state.data(), time, counters_->steps);
}

namespace {

/// Along the vectors that a singular matrix maps to zero: across the rows that say most.
template <class Scalar>
Eigen::Matrix<Scalar, 3, 1> kernel(const Eigen::Matrix<Scalar, 3, 3>& matrix) {
  Eigen::Matrix<Scalar, 3, 1> best = Eigen::Matrix<Scalar, 3, 1>::Zero();
  for (int skip = 0; skip < 3; ++skip) {
    const auto a = matrix.row((skip + 1) % 3), b = matrix.row((skip + 2) % 3);
    const Eigen::Matrix<Scalar, 3, 1> normal(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                             a[0] * b[1] - a[1] * b[0]);
    if (normal.norm() > best.norm()) best = normal;
  }
  return best / best.norm();
}

RadauTableau make() {
  RadauTableau made;
  const double root = std::sqrt(6.0);
  made.node = Vec3((4 - root) / 10, (4 + root) / 10, 1);
  // Collocation: the matrix integrates polynomials of degree 2 from 0 to each node.
  Mat3 values, integrals;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      values(i, k) = std::pow(made.node[i], k);
      integrals(i, k) = std::pow(made.node[i], k + 1) / (k + 1);
    }
  }
  made.inverse = values * integrals.inverse();
  // The zeros of the polynomial z^3 - 9 z^2 + 36 z - 60, whose inverses are in closed form.
  const double nine = std::cbrt(9.0);
  made.real = 30 / (6 + nine * (nine - 1));
  const std::complex<double> inverse_pair((12 - nine * (nine - 1)) / 60,
                                          -nine * (nine + 1) * std::sqrt(3.0) / 60);
  const std::complex<double> pair = 1.0 / inverse_pair;
  made.re = pair.real();
  made.im = pair.imag();
  const Eigen::Matrix3cd shifted =
      made.inverse.cast<std::complex<double>>() - pair * Eigen::Matrix3cd::Identity();
  const Eigen::Vector3cd turning = kernel<std::complex<double>>(shifted);
  made.to_stage.col(0) = kernel<double>(made.inverse - made.real * Mat3::Identity());
  made.to_stage.col(1) = turning.real();
  made.to_stage.col(2) = turning.imag();
  made.from_stage = made.to_stage.inverse();
  made.error = Vec3(-13 - 7 * root, -13 + 7 * root, -1) / 3;
  return made;
}

}  // namespace

const RadauTableau& RadauTableau::get() {
  static const RadauTableau tableau = make();
  return tableau;
}

namespace {

constexpr int kIterations = 12;   // of Newton's method in a step that is not too long
constexpr double kSlow = 0.8;     // a contraction above it is none
constexpr double kFloor = 1e-16;  // of the length: changes below it are roundings
constexpr double kNoise = 1e-10;  // of the length: where stiff forces' roundings end the iteration
constexpr double kMostTurn = 1;   // rad, of the ends in a step: whole turns stay known
constexpr double kFarthest = 4;   // steps before: farther no polynomial is followed

}  // namespace

void RadauStep::rebuild(const World& world) {
  world_ = &world;
  system_.rebuild(world);
  const std::size_t n = system_.particles(), size = system_.size();
  for (Array* array : {&x_, &v_, &next_x_, &next_v_, &acceleration_}) array->assign(3 * n, 0.0);
  for (Array* array : {&tension_, &real_right_, &zero_, &speed_, &drift_, &change_})
    array->assign(size, 0.0);
  for (auto* stages : {&z_, &before_, &left_}) {
    for (Array& array : *stages) array.assign(size, 0.0);
  }
  for (auto* stages : {&stage_x_, &stage_v_}) {
    for (Array& array : *stages) array.assign(3 * n, 0.0);
  }
  complex_right_.assign(size, Complex{});
  real_.resize(size);
  complex_.resize(size);
  free_ = 0;
  for (std::size_t i = 0; i < n; ++i) free_ += system_.is_held(i) ? 0 : 1;
}

void RadauStep::load(double time) {
  const Connector& connector = world_->connectors[0];
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      x_[3 * i + c] = connector.position[i][static_cast<int>(c)];
      v_[3 * i + c] = connector.velocity[i][static_cast<int>(c)];
    }
  }
  system_.load_twist(*world_);
  system_.place(time, x_.data(), v_.data());
  std::ranges::fill(tension_, 0.0);
  system_.restore_lengths(0, tension_.data(), x_.data());
  system_.stop_stretch(x_.data(), v_.data());
  system_.follow_turn(system_.end_turn(x_.data()));  // particles that come or go change it at once
  system_.find_tensions(x_.data(), v_.data(), tension_.data());
  before_h_ = 0;
}

void RadauStep::store(World& world) const {
  system_.store_twist(world);
  Connector& connector = world.connectors[0];
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      connector.position[i][static_cast<int>(c)] = x_[3 * i + c];
      connector.velocity[i][static_cast<int>(c)] = v_[3 * i + c];
    }
  }
}

/// The stages as the step before goes on, or as they fly straight.
void RadauStep::guess(double h) {
  const Vec3& node = tableau_.node;
  const std::size_t n = system_.particles();
  const bool follows = before_h_ > 0 && h <= kFarthest * before_h_;
  for (int j = 0; j < 3; ++j) {
    Array& z = z_[static_cast<std::size_t>(j)];
    if (!follows) {
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t c = 0; c < 3; ++c) z[4 * i + c] = node[j] * h * v_[3 * i + c];
        z[4 * i + 3] = tension_[4 * i + 3];
      }
      continue;
    }
    // Lagrange's polynomials: of places with the start, where the difference is zero; of tensions
    // without it.
    const double at = 1 + node[j] * h / before_h_;
    Vec3 place, tension;
    for (int k = 0; k < 3; ++k) {
      tension[k] = 1;
      for (int other = 0; other < 3; ++other) {
        if (other != k) tension[k] *= (at - node[other]) / (node[k] - node[other]);
      }
      place[k] = tension[k] * at / node[k];
    }
    place[2] -= 1;  // from the end of the step before
    for (std::size_t i = 0; i < 4 * n; ++i) {
      const Vec3& weight = i % 4 == 3 ? tension : place;
      z[i] = weight[0] * before_[0][i] + weight[1] * before_[1][i] + weight[2] * before_[2][i];
    }
  }
}

/// Places and velocities of the particles that nothing holds in the stages.
void RadauStep::find_stages(double h) {
  const Mat3& inverse = tableau_.inverse;
  for (int j = 0; j < 3; ++j) {
    const auto s = static_cast<std::size_t>(j);
    for (std::size_t i = 0; i < system_.particles(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t u = 4 * i + c;
        stage_x_[s][3 * i + c] = x_[3 * i + c] + z_[s][u];
        stage_v_[s][3 * i + c] =
            (inverse(j, 0) * z_[0][u] + inverse(j, 1) * z_[1][u] + inverse(j, 2) * z_[2][u]) / h;
      }
    }
  }
}

/// One iteration of Newton's method; how far it moves (m).
double RadauStep::iterate(double time, double h) {
  const Mat3 &inverse = tableau_.inverse, &from = tableau_.from_stage, &to = tableau_.to_stage;
  find_stages(h);
  for (int j = 0; j < 3; ++j) {
    const auto s = static_cast<std::size_t>(j);
    for (std::size_t i = 0; i < v_.size(); ++i) {
      acceleration_[i] =
          (inverse(j, 0) * (stage_v_[0][i] - v_[i]) + inverse(j, 1) * (stage_v_[1][i] - v_[i]) +
           inverse(j, 2) * (stage_v_[2][i] - v_[i])) /
          h;
    }
    system_.place(time + tableau_.node[j] * h, stage_x_[s].data(), stage_v_[s].data());
    system_.residual(stage_x_[s].data(), stage_v_[s].data(), acceleration_.data(), z_[s].data(),
                     left_[s].data());
  }
  for (std::size_t i = 0; i < system_.size(); ++i) {
    const Vec3 left(left_[0][i], left_[1][i], left_[2][i]);
    real_right_[i] = from.row(0).dot(left);
    complex_right_[i] = {from.row(1).dot(left), -from.row(2).dot(left)};
  }
  const Complex pair{tableau_.re / h, tableau_.im / h};
  system_.scale_links(tableau_.real / h, real_right_.data());
  system_.scale_links(pair, complex_right_.data());
  real_twist_.solve(real_, real_right_.data());
  complex_twist_.solve(complex_, complex_right_.data());
  double moved = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3 row = to.row(static_cast<int>(j));
    Array& change = left_[j];
    for (std::size_t i = 0; i < system_.size(); ++i) {
      change[i] =
          row[0] * real_right_[i] + row[1] * complex_right_[i].re - row[2] * complex_right_[i].im;
      z_[j][i] += change[i];
    }
    moved = std::max(moved, rms(change.data()));
  }
  ++iterations_;
  return moved;
}

double RadauStep::rms(const double* four) const {
  double sum = 0;
  for (std::size_t i = 0; i < system_.particles(); ++i) {
    if (system_.is_held(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) sum += four[4 * i + c] * four[4 * i + c];
  }
  return free_ > 0 ? std::sqrt(sum / static_cast<double>(free_)) : 0;
}

RadauStep::Result RadauStep::attempt(double time, double h, double within, double limit) {
  h_ = h;
  system_.place(time, x_.data(), v_.data());
  system_.differentiate(x_.data(), v_.data(), tension_.data());
  const double real = tableau_.real / h;
  const Complex pair{tableau_.re / h, tableau_.im / h};
  system_.assemble(real, real_);
  system_.assemble(pair, complex_);
  real_.factor();
  complex_.factor();
  real_twist_.factor(real_, system_.twist_slope(), system_.twist_share(real));
  complex_twist_.factor(complex_, system_.twist_slope(), system_.twist_share(pair));
  guess(h);
  const double floor = kFloor * system_.length();
  double before = 0;
  for (int i = 0; i < kIterations; ++i) {
    check_stop();
    const double moved = iterate(time, h);
    if (!std::isfinite(moved)) return {};
    const double contraction = i > 0 ? moved / before : kSlow;
    before = moved;
    const bool slow = i > 1 && contraction > kSlow;
    if (moved <= floor || moved * contraction / (1 - std::min(contraction, kSlow)) <= within ||
        (slow && moved <= kNoise * system_.length())) {
      if (!finish(time, h)) return {};
      const double error = estimate(time, h, limit);
      return {std::isfinite(error), error};
    }
    if (slow) return {};
  }
  return {};
}

/// The state at the step's end, and what the estimate of the error takes from the stages.
bool RadauStep::finish(double time, double h) {
  find_stages(h);
  for (std::size_t i = 0; i < system_.particles(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      double drift = 0, change = 0;
      for (std::size_t s = 0; s < 3; ++s) {
        drift += tableau_.error[static_cast<int>(s)] * z_[s][4 * i + c];
        change += tableau_.error[static_cast<int>(s)] * (stage_v_[s][3 * i + c] - v_[3 * i + c]);
      }
      drift_[4 * i + c] = drift / h;
      change_[4 * i + c] = change / h;
    }
  }
  next_x_ = stage_x_[2];
  next_v_ = stage_v_[2];
  system_.place(time + h, next_x_.data(), next_v_.data());
  if (!system_.restore_lengths(h, z_[2].data(), next_x_.data())) return false;
  system_.stop_stretch(next_x_.data(), next_v_.data());
  next_turn_ = system_.end_turn(next_x_.data());
  return std::abs(next_turn_ - system_.followed_turn()) < kMostTurn;
}

/// By the embedded formula of order 3, filtered by the real matrix; once more from the state that
/// is off by so much where it is too large for `limit`, so that what is stiff and dies away in the
/// step is not taken for an error.
double RadauStep::estimate(double time, double h, double limit) {
  system_.place(time, x_.data(), v_.data());
  real_right_ = zero_;
  const double error = filter(h, x_, v_);
  if (!(error > limit)) return error;
  const double rate = tableau_.real / h;
  Array &x = stage_x_[0], &v = stage_v_[0];  // of no use any more
  x = x_;
  v = v_;
  for (std::size_t i = 0; i < system_.particles(); ++i) {
    if (system_.is_held(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      x[3 * i + c] += real_right_[4 * i + c];
      v[3 * i + c] += rate * real_right_[4 * i + c] - speed_[4 * i + c];
    }
  }
  return filter(h, x, v);
}

/// A solve of the error filter, from the derivative at a state with the tensions in `real_right_`,
/// which becomes the errors of positions and the tensions.
double RadauStep::filter(double h, const Array& x, const Array& v) {
  const double rate = tableau_.real / h;
  Array& right = left_[1];
  std::ranges::fill(acceleration_, 0.0);
  system_.residual(x.data(), v.data(), acceleration_.data(), real_right_.data(), right.data());
  std::ranges::fill(speed_, 0.0);
  for (std::size_t i = 0; i < system_.particles(); ++i) {
    if (system_.is_held(i)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t u = 4 * i + c;
      speed_[u] = v[3 * i + c] + drift_[u];
      right[u] += system_.mass()[i] * (change_[u] + rate * speed_[u]);
    }
  }
  system_.add_damping(speed_.data(), right.data());
  system_.scale_links(rate, right.data());
  real_twist_.solve(real_, right.data());
  std::swap(right, real_right_);
  return rms(real_right_.data());
}

void RadauStep::accept() {
  x_ = next_x_;
  v_ = next_v_;
  std::swap(z_, before_);
  tension_ = before_[2];
  before_h_ = h_;
  system_.follow_turn(next_turn_);
}

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
