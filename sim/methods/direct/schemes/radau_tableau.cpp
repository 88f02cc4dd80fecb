#include "sim/methods/direct/schemes/radau_tableau.h"

#include <Eigen/LU>
#include <cmath>
#include <complex>

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

}  // namespace taut::direct
