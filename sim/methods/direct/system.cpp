#include "sim/methods/direct/system.h"

#include <algorithm>
#include <cmath>

#include "sim/methods/direct/kernels.h"
#include "sim/methods/direct/tridiagonal.h"

namespace taut::direct {
namespace {

Quat quaternion(const double* c) {
  return {c[0], c[1], c[2], c[3]};
}

Vec3 vector(const double* c) {
  return {c[0], c[1], c[2]};
}

}  // namespace

/// How the bodies lie and spin.
void System::turn_bodies(const double* q, const double* v) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    RigidBody& body = bodies_[b];
    const Quat rotation = quaternion(q + body_at(b) + 3);
    // q' = W q / 2, W the spin as a quaternion.
    body.spin = 2 / rotation.squaredNorm() *
                (quaternion(v + body_at(b) + 3) * rotation.conjugate()).vec();
    body.rotation = rotation.normalized().toRotationMatrix();
    body.world_inverse_inertia = body.rotation * body.inverse_inertia * body.rotation.transpose();
    for (const std::size_t e : ends_of(body)) ends_[e].arm = body.rotation * ends_[e].local_arm;
  }
}

/// What of the bodies' accelerations no tension causes, once they are turned.
void System::lead_bodies() {
  for (RigidBody& body : bodies_) {
    const Vec3 momentum = body.rotation * (body.inertia * (body.rotation.transpose() * body.spin));
    body.spin_rate = body.world_inverse_inertia * momentum.cross(body.spin);
    for (const std::size_t e : ends_of(body)) {
      End& end = ends_[e];
      end.lead = body.spin.cross(body.spin.cross(end.arm)) + body.spin_rate.cross(end.arm);
    }
  }
}

/// Places the points that bodies hold, once these are turned.
void System::place_carried(double* q, double* v) {
  for (const End& end : ends_) {
    if (end.body == kNone) continue;
    const double *centre = q + body_at(end.body), *velocity = v + body_at(end.body);
    set(q, end.point, vector(centre) + end.arm);
    set(v, end.point, vector(velocity) + bodies_[end.body].spin.cross(end.arm));
  }
}

void System::read_holds(double time, double* q, double* v) {
  for (End& end : ends_) {
    if (end.body != kNone) continue;
    end.lead = -world_->gravity;
    if (rests(end.to, time)) continue;
    const PointMotion motion = hold_motion(*world_, end.to, time);
    set(q, end.point, motion.position);
    set(v, end.point, motion.velocity);
    end.lead += motion.acceleration;
    if (plane_ && !plane_->holds(end.lead)) left_plane_ = end.lead;
  }
}

/// Adds the ends to the tensions' system, whose row i is -u_i . (a_{i+1} - a_i) as far as tensions
/// cause it = l |u'|^2 + u_i . (the rest of a_{i+1} - a_i).
void System::add_ends(bool with_leads) {
  for (const End& end : ends_) {
    const Vec3 u = at(u_, end.link);
    if (with_leads) right_[end.link] -= scale_[end.link] * end.pull * u.dot(end.lead);
    if (end.body == kNone) continue;
    const RigidBody& body = bodies_[end.body];
    const Vec3 turn = end.arm.cross(u);
    const double mobility = 1 / body.mass + turn.dot(body.world_inverse_inertia * turn);
    const std::size_t i = end.link;
    (end.pull > 0 ? near_ : far_)[i] = mobility * scale_[i] * scale_[i];
    if (end.pull > 0 && i > 0) turned_[i - 1] = far_[i - 1] * near_[i];
    if (end.pull < 0 && i + 1 < points_) turned_[i] = far_[i] * near_[i + 1];
  }
}

void System::solve() {
  solve_chain(points_, near_, far_, off_, turned_, right_, unknown_, work_space_);
  if (!coupled_.empty()) add_couplings();
}

/// Bodies that several links hold add E Q E' to the tridiagonal A, E the columns of the unit
/// matrix for those links: T = A^-1 r - A^-1 E (1 + Q G)^-1 Q E' A^-1 r, G = E' A^-1 E (Woodbury).
void System::add_couplings() {
  const auto index = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  dense_.setZero();
  for (const Coupling& c : couplings_) {
    const End &a = ends_[c.a], &b = ends_[c.b];
    const RigidBody& body = bodies_[a.body];
    const Vec3 u = at(u_, a.link), v = at(u_, b.link);
    dense_(index(c.row), index(c.column)) +=
        a.pull * b.pull *
        (u.dot(v) / body.mass + a.arm.cross(u).dot(body.world_inverse_inertia * b.arm.cross(v)));
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    dense_right_[index(k)] = tension_of(coupled_[k]);
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    double* response = response_.data() + k * points_;
    std::fill_n(right_, points_, 0.0);
    right_[coupled_[k]] = scale_[coupled_[k]];
    solve_chain(points_, near_, far_, off_, turned_, right_, response, work_space_);
    for (std::size_t j = 0; j < coupled_.size(); ++j) {
      gain_(index(j), index(k)) = scale_[coupled_[j]] * response[coupled_[j]];
    }
  }
  coupled_system_.noalias() = dense_ * gain_;
  coupled_system_.diagonal().array() += 1;
  share_.noalias() = dense_ * dense_right_;
  decomposed_.compute(coupled_system_);
  dense_right_ = decomposed_.solve(share_);
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    const double* response = response_.data() + k * points_;
    for (std::size_t i = 0; i < points_; ++i) unknown_[i] -= dense_right_[index(k)] * response[i];
  }
}

/// The bodies' own accelerations.
void System::move_bodies(const double* q, double* out) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : ends_of(body)) {
      const Vec3 pull = ends_[e].pull * tension_of(ends_[e].link) * at(u_, ends_[e].link);
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    const Vec3 turn = body.world_inverse_inertia * torque;
    const Vec3 rise = (body.spin_rate + turn) / 2;
    const double* p = q + body_at(b) + 3;
    const Quat across = Quat(0, rise.x(), rise.y(), rise.z()) * quaternion(p);
    const double inward = body.spin.squaredNorm() / 4;
    double* a = out + body_at(b);
    const Vec3 fall = world_->gravity + force / body.mass;
    a[0] = fall.x(), a[1] = fall.y(), a[2] = fall.z();
    a[3] = across.w() - inward * p[0];
    a[4] = across.x() - inward * p[1];
    a[5] = across.y() - inward * p[2];
    a[6] = across.z() - inward * p[3];
  }
}

void System::acceleration(double time, double* q, double* v, double* a) {
  turn_bodies(q, v);
  lead_bodies();
  place_carried(q, v);
  read_holds(time, q, v);
  kernels::directions(axes_, stride_, q, inverse_rest_, u_);
  kernels::neighbours(axes_, stride_, u_, beside_, apart_, off_, turned_);
  kernels::centripetal(axes_, stride_, v, inverse_rest_, weight_, right_);
  add_ends(true);
  solve();
  kernels::pull(axes_, stride_, u_, unknown_, after_, before_, falls_, gravity_axes_, a);
  move_bodies(q, a);
  std::fill(a + size() - kLanes, a + size(), 0.0);
}

void System::place(double time, double* q, double* v) {
  turn_bodies(q, v);
  place_carried(q, v);
  read_holds(time, q, v);
}

/// Moves bodies, or changes their velocities, by what the unknowns pull.
void System::shift_bodies(double* q, double* v, bool rates) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : ends_of(body)) {
      const Vec3 pull = ends_[e].pull * tension_of(ends_[e].link) * at(u_, ends_[e].link);
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    double* out = (rates ? v : q) + body_at(b);
    const Vec3 shift = force / body.mass, turn = body.world_inverse_inertia * torque / 2;
    const Quat change =
        Quat(0, turn.x(), turn.y(), turn.z()) * quaternion(q + body_at(b) + 3);
    out[0] += shift.x(), out[1] += shift.y(), out[2] += shift.z();
    out[3] += change.w(), out[4] += change.x(), out[5] += change.y(), out[6] += change.z();
  }
}

void System::project(double time, double* q, double* v) {
  constexpr int kRounds = 8;
  constexpr double kRounding = 4e-16;  // of a length
  for (int round = 0;; ++round) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      Eigen::Map<Eigen::Vector4d> p(q + body_at(b) + 3), r(v + body_at(b) + 3);
      p.normalize();
      r -= p.dot(r) * p;
    }
    place(time, q, v);
    kernels::directions(axes_, stride_, q, inverse_rest_, u_);
    kernels::neighbours(axes_, stride_, u_, beside_, apart_, off_, turned_);
    const double most = kernels::excess(axes_, stride_, u_, weight_, right_);
    if (most <= kRounding || round == kRounds) break;
    add_ends(false);
    solve();
    kernels::push(axes_, stride_, u_, unknown_, after_, before_, q);
    shift_bodies(q, v, false);
  }
  kernels::lengthening(axes_, stride_, u_, v, inverse_rest_, weight_, right_);
  add_ends(false);
  solve();
  kernels::push(axes_, stride_, u_, unknown_, after_, before_, v);
  shift_bodies(q, v, true);
  if (floats_) keep_angular_momentum(q, v);
}

double System::norm(const double* change) const {
  double sum = kernels::squares(bodies_at(), change);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* x = change + body_at(b);
    const RigidBody& body = bodies_[b];
    sum += x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    const double turn = x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6];
    sum += 4 * turn * body.inertia.trace() / (2 * body.mass);
  }
  return std::sqrt(sum / static_cast<double>(points_ + bodies_.size()));
}

double System::frequency() const {
  return std::sqrt(largest(stride_, unknown_, wave_));
}

double System::tension(std::size_t span) const {
  return tension_of(spans_[span].first_link);
}

}  // namespace taut::direct
