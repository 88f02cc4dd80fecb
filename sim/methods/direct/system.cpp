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

/// The slowest motion that errors are looked at in, as a share of a pendulum's time scale.
constexpr double kMemory = 0.3;

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
    body.spin =
        2 / rotation.squaredNorm() * (quaternion(v + body_at(b) + 3) * rotation.conjugate()).vec();
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
  note_tensions();
  kernels::pull(axes_, stride_, u_, unknown_, after_, before_, falls_, gravity_axes_, a);
  move_bodies(q, a);
  std::fill(a + size() - kLanes, a + size(), 0.0);
}

void System::note_tensions() {
  frequency_ = std::sqrt(largest(stride_, unknown_, wave_));
  for (std::size_t i = 0; i < stride_; ++i) {
    stiffness_[i] = std::max(tension_of(i), 0.0) * inverse_rest_[i];
  }
}

void System::place(double time, double* q, double* v) {
  turn_bodies(q, v);
  place_carried(q, v);
  read_holds(time, q, v);
}

/// Moves bodies by `place` times what the unknowns pull, and changes their velocities by `speed`
/// times that.
void System::shift_bodies(double place, double speed, double* q, double* v) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : ends_of(body)) {
      const Vec3 pull = ends_[e].pull * tension_of(ends_[e].link) * at(u_, ends_[e].link);
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    const Vec3 shift = force / body.mass, turn = body.world_inverse_inertia * torque / 2;
    const Quat change = Quat(0, turn.x(), turn.y(), turn.z()) * quaternion(q + body_at(b) + 3);
    const double all[7] = {shift.x(),  shift.y(),  shift.z(), change.w(),
                           change.x(), change.y(), change.z()};
    for (std::size_t k = 0; k < 7; ++k) {
      q[body_at(b) + k] += place * all[k];
      v[body_at(b) + k] += speed * all[k];
    }
  }
}

/// Sets up the tensions' system of where q is.
void System::assemble(const double* q) {
  kernels::directions(axes_, stride_, q, inverse_rest_, u_);
  kernels::neighbours(axes_, stride_, u_, beside_, apart_, off_, turned_);
}

void System::unit_quaternions(double* q, double* v) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Eigen::Map<Eigen::Vector4d> p(q + body_at(b) + 3), r(v + body_at(b) + 3);
    p.normalize();
    r -= p.dot(r) * p;
  }
}

/// Stops what velocities change lengths; the system is that of q.
void System::stop_lengthening(double* q, double* v) {
  kernels::lengthening(axes_, stride_, u_, v, inverse_rest_, weight_, right_);
  add_ends(false);
  solve();
  kernels::push(axes_, stride_, u_, unknown_, after_, before_, v);
  shift_bodies(0, 1, q, v);
}

void System::project(double time, double* q, double* v) {
  constexpr int kRounds = 8;
  constexpr double kRounding = 4e-16;  // of a length
  for (int round = 0;; ++round) {
    unit_quaternions(q, v);
    place(time, q, v);
    assemble(q);
    const double most = kernels::excess(axes_, stride_, u_, weight_, right_);
    if (most <= kRounding || round == kRounds) break;
    add_ends(false);
    solve();
    kernels::push(axes_, stride_, u_, unknown_, after_, before_, q);
    shift_bodies(1, 0, q, v);
  }
  stop_lengthening(q, v);
  if (floats_) keep_angular_momentum(q, v);
}

double System::accumulated(double span, double saturation, double* a) {
  clear_held(a);
  const double size = norm(a), memory = kMemory * time_scale();
  factor_waves(1 / (memory * memory));
  solve_waves(a);
  const double displacement = norm(a);
  if (!(displacement > 0)) return displacement;
  const double frequency = std::sqrt(size / displacement);
  const double grown = std::max(1.0, frequency * span / 2);
  return displacement * std::min(saturation / (frequency * frequency), grown);
}

double System::keep(double time, double per_time, double* q, double* v) {
  unit_quaternions(q, v);
  place(time, q, v);
  assemble(q);
  const double most = kernels::excess(axes_, stride_, u_, weight_, right_);
  add_ends(false);
  solve();
  std::fill_n(work_u_, bodies_at(), 0.0);
  kernels::push(axes_, stride_, u_, unknown_, after_, before_, work_u_);
  kernels::add(bodies_at(), 1, work_u_, q);
  kernels::add(bodies_at(), per_time, work_u_, v);
  shift_bodies(1, per_time, q, v);
  unit_quaternions(q, v);
  place(time, q, v);
  assemble(q);
  stop_lengthening(q, v);
  return most;
}

double System::shake(double time, double factor, double* q, double* next, double* v) {
  assemble(q);
  add_ends(false);
  kernels::pull(axes_, stride_, u_, unknown_, after_, before_, falls_, gravity_axes_, work_u_);
  kernels::add(bodies_at(), factor, work_u_, next);
  place(time, next, v);
  kernels::directions(axes_, stride_, next, inverse_rest_, work_u_);
  const double most = kernels::shake(axes_, stride_, 1 / factor, weight_, work_u_, right_);
  std::copy_n(unknown_, stride_, change_);
  solve();
  std::fill_n(work_u_, bodies_at(), 0.0);
  kernels::push(axes_, stride_, u_, unknown_, after_, before_, work_u_);
  kernels::add(bodies_at(), factor, work_u_, next);
  kernels::add(stride_, 1, change_, unknown_);
  note_tensions();
  return most;
}

void System::clear_held(double* array) const {
  for (const End& end : ends_) set(array, end.point, Vec3::Zero());
}

void System::factor_waves(double sigma_squared) {
  for (std::size_t i = 0; i < points_; ++i) {
    const bool held = held_[i];
    const double before = stiffness_[i - 1], after = stiffness_[i];
    pivot_[i] = held ? 1 : sigma_squared / inverse_mass_[i] + before + after;
    up_[i] = held ? 0 : after;
    down_[i] = held_[i + 1] ? 0 : after;
  }
  factor_twisted(points_, pivot_, up_, down_, work_space_);
  sigma_squared_ = sigma_squared;
}

void System::solve_waves(double* x) const {
  for (int c = 0; c < axes_; ++c) {
    double* r = x + row(c);
    for (std::size_t i = 0; i < points_; ++i) r[i] = held_[i] ? 0 : r[i] / inverse_mass_[i];
  }
  solve_twisted(points_, pivot_, up_, down_, axes_, stride_, x);
  for (std::size_t k = bodies_at(); k < size() - kLanes; ++k) x[k] /= sigma_squared_;
}

double System::turning(const double* x) const {
  return kernels::steepest(axes_, stride_, x, inverse_rest_);
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

double System::tension(std::size_t span) const {
  return tension_of(spans_[span].first_link);
}

}  // namespace taut::direct
