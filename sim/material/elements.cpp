#include "sim/material/elements.h"

#include "sim/motion/rotation.h"

namespace taut::material {
namespace {

Mat3 across(const Vec3& unit) {
  return Mat3::Identity() - unit * unit.transpose();
}

}  // namespace

// C^2 = 4 tan^2(a/2) = 4 |t1 - t0|^2 / |t0 + t1|^2, which loses no digits where a is small.
Bend::Bend(const Vec3& e0, const Vec3& e1, const Vec3& rest)
    : inverse0_(1 / e0.norm()),
      inverse1_(1 / e1.norm()),
      t0_(inverse0_ * e0),
      t1_(inverse1_ * e1),
      rest_(rest),
      curved_(!rest.isZero(0)) {
  straight_ = (t0_ + t1_).squaredNorm() / 4;
  apart_ = t1_ - t0_;
  cosine_ = 1 - apart_.squaredNorm() / 2;
}

double Bend::energy(double stiffness) const {
  const double straight = stiffness * apart_.squaredNorm() / (2 * straight_);
  if (!curved_) return straight;
  return straight + stiffness * (rest_.squaredNorm() / 2 - along_rest().value);
}

// C = t0 x t1 / q with q = (1 + t0 . t1) / 2, of which rest . C is `value`.
Bend::Along Bend::along_rest() const {
  const double value = rest_.dot(t0_.cross(t1_)) / straight_, share = value / 2;
  return {value, (t1_.cross(rest_) - share * t1_) / straight_,
          (rest_.cross(t0_) - share * t0_) / straight_};
}

// The parts of t1 - t0 across the edges: stiff bends would make a pull of the rounding along them.
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
  if (!curved_) return;
  const Along along = along_rest();
  by_e0 -= stiffness * inverse0_ * (across(t0_) * along.by_t0);
  by_e1 -= stiffness * inverse1_ * (across(t1_) * along.by_t1);
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
  Stiffness found{inverse0_ * inverse0_ * own(t0_, a, across0),
                  inverse0_ * inverse1_ * (second * a * b.transpose() + first * across0 * across1),
                  inverse1_ * inverse1_ * own(t1_, b, across1)};
  if (curved_) add_rest(stiffness, found);
  return found;
}

void Bend::add_rest(double stiffness, Stiffness& found) const {
  const Along along = along_rest();
  const double half = 1 / (2 * straight_);
  const Mat3 across0 = across(t0_), across1 = across(t1_);
  // Of a function of a unit vector t = e / |e| with derivative g and second derivative h by t.
  const auto own = [](const Vec3& t, const Mat3& across_t, const Vec3& g, const Mat3& h) -> Mat3 {
    const Mat3 turn = t * (across_t * g).transpose();
    return across_t * h * across_t - t.dot(g) * across_t - turn - turn.transpose();
  };
  const Mat3 h0 = along.by_t0 * t1_.transpose(), h1 = along.by_t1 * t0_.transpose();
  Mat3 turned;  // rest x
  turned << 0, -rest_.z(), rest_.y(), rest_.z(), 0, -rest_.x(), -rest_.y(), rest_.x(), 0;
  const Mat3 mixed =
      -turned / straight_ - half * (along.value * Mat3::Identity() + along.by_t0 * t0_.transpose() +
                                    t1_ * along.by_t1.transpose());
  found.e0_e0 -= stiffness * inverse0_ * inverse0_ *
                 own(t0_, across0, along.by_t0, -half * (h0 + h0.transpose()));
  found.e1_e1 -= stiffness * inverse1_ * inverse1_ *
                 own(t1_, across1, along.by_t1, -half * (h1 + h1.transpose()));
  found.e0_e1 -= stiffness * inverse0_ * inverse1_ * across0 * mixed * across1;
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

Carry::Carry(const Vec3& e0, const Vec3& e1)
    : inverse0_(1 / e0.norm()),
      inverse1_(1 / e1.norm()),
      t0_(inverse0_ * e0),
      t1_(inverse1_ * e1),
      share_(1 / (1 + t0_.dot(t1_))),
      slope_(share_ * t0_.cross(t1_)) {}

Bend::Stiffness Carry::second() const {
  const auto own = [&](const Mat3& by_direction, const Vec3& t) -> Mat3 {
    const Mat3 full =
        by_direction * (Mat3::Identity() - t * t.transpose()) - slope_ * t.transpose();
    return (full + full.transpose()) / 2;
  };
  const Mat3 by_t0 = share_ * (-cross_matrix(t1_) - slope_ * t1_.transpose());
  const Mat3 by_t1 = share_ * (cross_matrix(t0_) - slope_ * t0_.transpose());
  return {inverse0_ * inverse0_ * own(by_t0, t0_),
          inverse0_ * inverse1_ * by_t1 * (Mat3::Identity() - t1_ * t1_.transpose()),
          inverse1_ * inverse1_ * own(by_t1, t1_)};
}

}  // namespace taut::material
