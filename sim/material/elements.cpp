#include "sim/material/elements.h"

namespace taut::material {
namespace {

Mat3 across(const Vec3& unit) {
  return Mat3::Identity() - unit * unit.transpose();
}

}  // namespace

// C^2 = 4 tan^2(a/2) = 4 |t1 - t0|^2 / |t0 + t1|^2, which loses no digits where a is small.
Bend::Bend(const Vec3& e0, const Vec3& e1)
    : inverse0_(1 / e0.norm()), inverse1_(1 / e1.norm()), t0_(inverse0_ * e0), t1_(inverse1_ * e1) {
  straight_ = (t0_ + t1_).squaredNorm() / 4;
  apart_ = t1_ - t0_;
  cosine_ = 1 - apart_.squaredNorm() / 2;
}

double Bend::energy(double stiffness) const {
  return stiffness * apart_.squaredNorm() / (2 * straight_);
}

// The parts of t1 - t0 across the edges: what rounding leaves along them, stiff bends would make a
// pull of.
Vec3 Bend::turn0() const {
  return apart_ - t0_.dot(apart_) * t0_;
}
Vec3 Bend::turn1() const {
  return t1_.dot(apart_) * t1_ - apart_;
}

// With c the cosine of a, C^2 / 2 = 2 (1 - c) / (1 + c), whose derivative by c is -4 / (1 + c)^2,
// and 1 + c = 2 cos^2(a/2). Of c the derivatives are (t1 - c t0) / |e0| and (t0 - c t1) / |e1|.
void Bend::slope(double stiffness, Vec3& by_e0, Vec3& by_e1) const {
  const double by_cosine = -stiffness / (straight_ * straight_);
  by_e0 = by_cosine * inverse0_ * turn0();
  by_e1 = by_cosine * inverse1_ * turn1();
}

Bend::Stiffness Bend::stiffness(double stiffness) const {
  const double first = -stiffness / (straight_ * straight_);
  const double second = stiffness / (straight_ * straight_ * straight_);
  const Vec3 a = turn0(), b = turn1();
  const Mat3 across0 = across(t0_), across1 = across(t1_);
  const auto own = [&](const Vec3& t, const Vec3& slope, const Mat3& across_t) -> Mat3 {
    const Mat3 turn = t * slope.transpose();
    return second * slope * slope.transpose() -
           first * (turn + turn.transpose() + cosine_ * across_t);
  };
  return {inverse0_ * inverse0_ * own(t0_, a, across0),
          inverse0_ * inverse1_ * (second * a * b.transpose() + first * across0 * across1),
          inverse1_ * inverse1_ * own(t1_, b, across1)};
}

// With d = t1 - t0 and q = cos(a/2) the curvature is the vector d / q, across t0 + t1. Its rate
// there, with (q^2)' = -d . d' / 2, is (P + d d^T / 4 q^2) d' / q, P what is across t0 + t1.
void Bend::rate_slope(Mat3& by_e0, Mat3& by_e1) const {
  const Vec3 mean = (t0_ + t1_).normalized();
  const Mat3 rate =
      (across(mean) + apart_ * apart_.transpose() / (4 * straight_)) / std::sqrt(straight_);
  by_e0 = -inverse0_ * rate * across(t0_);
  by_e1 = inverse1_ * rate * across(t1_);
}

void Bend::resistance(double damping, const Vec3& e0_rate, const Vec3& e1_rate, Vec3& by_e0,
                      Vec3& by_e1) const {
  Mat3 slope0, slope1;
  rate_slope(slope0, slope1);
  const Vec3 moment = damping * (slope0 * e0_rate + slope1 * e1_rate);
  by_e0 = slope0.transpose() * moment;
  by_e1 = slope1.transpose() * moment;
}

Bend::Stiffness Bend::damping(double damping) const {
  Mat3 slope0, slope1;
  rate_slope(slope0, slope1);
  return {damping * slope0.transpose() * slope0, damping * slope0.transpose() * slope1,
          damping * slope1.transpose() * slope1};
}

Vec3 drag_force(const Vec3& edge, const Vec3& speed, double density_area, double across,
                double along) {
  const Vec3 unit = edge.normalized();
  const double forward = unit.dot(speed);
  const Vec3 sideways = speed - forward * unit;
  return -density_area / 2 *
         (across * sideways.norm() * sideways + along * std::abs(forward) * forward * unit);
}

Mat3 drag_slope(const Vec3& edge, const Vec3& speed, double density_area, double across_share,
                double along) {
  const Vec3 unit = edge.normalized();
  const double forward = unit.dot(speed);
  const Vec3 sideways = speed - forward * unit;
  const double flow = sideways.norm();
  Mat3 slope = 2 * along * std::abs(forward) * unit * unit.transpose();
  if (flow > 0) {
    slope += across_share * (flow * across(unit) + sideways * sideways.transpose() / flow);
  }
  return density_area / 2 * slope;
}

}  // namespace taut::material
