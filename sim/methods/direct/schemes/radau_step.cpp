#include "sim/methods/direct/schemes/radau_step.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "sim/motion/stop.h"

namespace taut::direct {
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

}  // namespace taut::direct
