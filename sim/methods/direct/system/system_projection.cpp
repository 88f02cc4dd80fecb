// The state of a system back to where its constraints and its momentum have it, and how far a
// change of state moves what it is the state of.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/system/system.h"
#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

/// The rotation rate that gives `momentum`, least where the inertia leaves a choice (a straight
/// chain about its own line).
Vec3 spin_for(const Mat3& inertia, const Vec3& momentum) {
  const auto [moments, axes] = principal_axes(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = axes.col(k);
    if (moments[k] > 1e-9 * moments[2]) spin += axis.dot(momentum) / moments[k] * axis;
  }
  return spin;
}

Mat3 point_inertia(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
}

}  // namespace

bool System::project(double time, double* q, double* rate) {
  unit(q, rate);
  if ((loops_ || !rows_.empty()) && !close(time, q, rate)) return false;
  if (floats_) restore_momentum(time, q, rate);
  return true;
}

void System::unit(double* q, double* rate) const {
  links_.normalise(q, rate);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Eigen::Map<Eigen::Vector4d> p(q + quaternion(b)), r(rate + quaternion(b));
    p.normalize();
    r -= p.dot(r) * p;
  }
}

/// How far the last points of the spans that close loops are from their places, in gaps_, and how
/// the rows stand; returns the largest gap of place (m).
double System::measure_gaps(double time, const double* q, const double* rate) {
  place(time, q, rate);
  double largest = 0;
  std::size_t p = 0;
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const Span& span = spans_[s];
    p += span.links + 1;
    if (!span.closes) continue;
    const End& end = ends_[span.last];
    Point goal;
    if (end.body == kNone) {
      const PointMotion motion = hold_motion(*world_, end.to, time);
      goal = {motion.position, motion.velocity};
    } else {
      goal = {centres_[end.body].position + end.arm,
              centres_[end.body].velocity + bodies_[end.body].spin.cross(end.arm)};
    }
    gaps_[s] = {goal.position - points_[p - 1].position, goal.velocity - points_[p - 1].velocity};
    largest = std::max(largest, gaps_[s].position.norm());
  }
  evaluate_rows(time);
  for (const Bordered& bordered : rows_) largest = std::max(largest, std::abs(bordered.value.gap));
  return largest;
}

/// Shares a gap among the links of its span, and finds what the masses do to restore the lengths
/// and the rows: impulses along the links and the rows' gradients, by the system of the tensions.
/// Adds both to `array` (q or its rate).
void System::spread(const double* q, Vec3 Point::*gap, double ConstraintRow::Value::*off,
                    double* array) {
  std::fill(still_.begin(), still_.end(), 0.0);
  turn_bodies(q, still_.data());
  lead_bodies();
  for (End& end : ends_) end.free_acceleration = Vec3::Zero();
  for (Bordered& bordered : rows_) bordered.right = -(bordered.value.*off);
  links_.assemble(q, still_.data());
  add_ends(q);
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      links_.add_right(i, links_.direction(q, i).dot(share));
    }
  }
  respond(q, still_.data());
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      links_.add(i, links_.direction(q, i), links_.inverse_rest(i) * share, still_.data());
    }
  }
  for (std::size_t k = 0; k < size(); ++k) array[k] += still_[k];
}

/// Closes the loops, and mends the rows, that an integrator's error has opened. Each round leaves
/// the square of the gap, or a quarter of it where links are straight. False where the places are
/// out of reach, or the state too far from one whose loops are closed.
bool System::close(double time, double* q, double* rate) {
  constexpr int kRounds = 24;        // quarters of the length that leave kOpen
  constexpr double kClosed = 1e-14;  // of the system's length, roundings
  constexpr double kOpen = 1e-11;    // of it, more than roundings of any closed loop
  double gap = measure_gaps(time, q, rate);
  for (int round = 0; round < kRounds && gap > kClosed * length_; ++round) {
    spread(q, &Point::position, &ConstraintRow::Value::gap, q);
    unit(q, rate);
    gap = measure_gaps(time, q, rate);
  }
  if (!(gap <= kOpen * length_)) return false;
  spread(q, &Point::velocity, &ConstraintRow::Value::rate, rate);
  unit(q, rate);
  return true;
}

/// Angular momentum and inertia about the centre of mass; points_ and centres_ are up to date.
System::Rotary System::rotary(double time) const {
  const Point mean = centre(time);
  Rotary sum;
  const auto count = [&](double mass, const Point& point) {
    const Vec3 r = point.position - mean.position;
    sum.momentum += mass * r.cross(point.velocity - mean.velocity);
    sum.inertia += point_inertia(mass, r);
  };
  for (std::size_t k = 0; k < points_.size(); ++k) count(point_mass_[k], points_[k]);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    count(part.mass, centres_[b]);
    const Mat3 own = part.rotation * part.inertia * part.rotation.transpose();
    sum.momentum += own * part.spin;
    sum.inertia += own;
  }
  return sum;
}

/// Gives a floating system its angular momentum back by one rigid rotation.
void System::restore_momentum(double time, double* q, double* rate) {
  place(time, q, rate);
  const Rotary now = rotary(time);
  const Vec3 spin = spin_for(now.inertia, spin_momentum_ - now.momentum);
  for (std::size_t i = 0; i < links_.count(); ++i) {
    const Vec3 u = links_.direction(q, i);
    links_.add(i, u, spin.cross(u), rate);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* p = q + quaternion(b);
    const Quat turn = quaternion_rate(spin, Quat(p[0], p[1], p[2], p[3]));
    double* r = rate + quaternion(b);
    r[0] += turn.w(), r[1] += turn.x(), r[2] += turn.y(), r[3] += turn.z();
  }
}

double System::projection_cost() const {
  return loops_ || !rows_.empty() ? 6 : floats_ ? 1.5 : plane_ ? 0 : 0.2;  // measured
}

double System::displacement(const double* change) const {
  double sum = 0;
  std::size_t count = 0;
  for (const Span& span : spans_) {
    sum += links_.displacement(change, span.offset, span.links);
    count += span.links;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    double turn = 0;
    for (std::size_t c = quaternion(b); c < quaternion(b) + 4; ++c) turn += change[c] * change[c];
    sum += 4 * turn * part.inertia.trace() / (2 * part.mass);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace taut::direct
