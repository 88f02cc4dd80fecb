#include "sim/methods/direct/system/system.h"

#include <algorithm>
#include <cmath>

namespace taut::direct {
namespace {

Quat quat(const double* c) {
  return {c[0], c[1], c[2], c[3]};
}

}  // namespace

/// How the bodies lie and spin.
void System::turn_bodies(const double* q, const double* rate) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Part& part = bodies_[b];
    const Quat rotation = quat(q + quaternion(b));
    // q' = W q / 2, W the spin as a quaternion.
    part.spin =
        2 / rotation.squaredNorm() * (quat(rate + quaternion(b)) * rotation.conjugate()).vec();
    part.rotation = rotation.normalized().toRotationMatrix();
    for (const std::size_t e : ends_of(part)) ends_[e].arm = part.rotation * ends_[e].local_arm;
  }
}

/// The bodies' accelerations without tensions, once the bodies are turned.
void System::lead_bodies() {
  for (Part& part : bodies_) {
    part.world_inverse_inertia = part.rotation * part.inverse_inertia * part.rotation.transpose();
    const Vec3 momentum = part.rotation * (part.inertia * (part.rotation.transpose() * part.spin));
    part.spin_rate = part.world_inverse_inertia * momentum.cross(part.spin);
    for (const std::size_t e : ends_of(part)) {
      End& end = ends_[e];
      end.free_acceleration =
          part.spin.cross(part.spin.cross(end.arm)) + part.spin_rate.cross(end.arm);
    }
  }
}

void System::read_holds(double time) {
  for (End& end : ends_) {
    if (end.body != kNone) continue;
    end.free_acceleration = -world_->gravity;
    if (rests(end.to, time)) continue;
    end.free_acceleration += hold_motion(*world_, end.to, time).acceleration;
    if (plane_ && !plane_->holds(end.free_acceleration)) left_plane_ = end.free_acceleration;
  }
}

/// Adds the ends to the tensions' system, whose row i is -u_i . (a_{i+1} - a_i) as far as tensions
/// cause it = l |u'|^2 + u_i . (the rest of a_{i+1} - a_i).
void System::add_ends(const double* q) {
  for (End& end : ends_) {
    end.along = links_.end_direction(q, end.link);
    links_.add_right(end.link, -end.pull * end.along.dot(end.free_acceleration));
    if (end.body == kNone) continue;
    const Part& part = bodies_[end.body];
    const Vec3 turn = end.arm.cross(end.along);
    links_.set_end(end.link, end.pull > 0,
                   1 / part.mass + turn.dot(part.world_inverse_inertia * turn));
  }
}

void System::couple() {
  body_ends_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].first_end = body_ends_.size();
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      if (ends_[e].body == b) body_ends_.push_back(e);
    }
  }
  coupled_.clear();
  couplings_.clear();
  const auto row = [&](std::size_t link) {
    const auto found = std::ranges::find(coupled_, link);
    if (found == coupled_.end()) {
      coupled_.push_back(link);
      return coupled_.size() - 1;
    }
    return static_cast<std::size_t>(found - coupled_.begin());
  };
  for (const Part& part : bodies_) {
    for (const std::size_t a : ends_of(part)) {
      for (const std::size_t b : ends_of(part)) {
        if (a != b) couplings_.push_back({a, b, row(ends_[a].link), row(ends_[b].link)});
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(coupled_.size());
  response_.resize(links_.count() * coupled_.size());
  dense_.resize(n, n);
  gain_.resize(n, n);
  dense_right_.resize(n);
}

/// Bodies that several links hold add E Q E' to the tridiagonal A, E the columns of the unit
/// matrix for those links: T = A^-1 r - A^-1 E (1 + Q G)^-1 Q E' A^-1 r, G = E' A^-1 E (Woodbury).
/// Where links hold a body more often than it can move, the system is singular and its least
/// solution serves: which one does not matter to the motion.
void System::add_couplings() {
  const auto row = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  dense_.setZero();
  for (const Coupling& c : couplings_) {
    const End &a = ends_[c.a], &b = ends_[c.b];
    const Part& part = bodies_[a.body];
    const Vec3 &u = a.along, &v = b.along;
    dense_(row(c.row), row(c.column)) +=
        a.pull * b.pull *
        (u.dot(v) / part.mass + a.arm.cross(u).dot(part.world_inverse_inertia * b.arm.cross(v)));
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    dense_right_[row(k)] = links_.tension(coupled_[k]);
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    double* response = response_.data() + k * links_.count();
    links_.clear_right();
    links_.add_right(coupled_[k], 1);
    links_.respond(response);
    for (std::size_t j = 0; j < coupled_.size(); ++j) {
      gain_(row(j), row(k)) = links_.scale(coupled_[j]) * response[coupled_[j]];
    }
  }
  system_.noalias() = dense_ * gain_;
  system_.diagonal().array() += 1;
  share_.noalias() = dense_ * dense_right_;
  decomposed_.compute(system_);
  decomposed_.solve(share_, dense_right_);
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    links_.add_response(response_.data() + k * links_.count(), -dense_right_[row(k)]);
  }
}

/// The bodies' own accelerations, and what tensions add to those of their ends.
void System::move_bodies(const double* q, double* out) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : ends_of(part)) {
      const Vec3 pull = ends_[e].pull * links_.tension(ends_[e].link) * ends_[e].along;
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    const Vec3 turn = part.world_inverse_inertia * torque;
    for (const std::size_t e : ends_of(part)) {
      ends_[e].free_acceleration += force / part.mass + turn.cross(ends_[e].arm);
    }
    const Vec3 rise = (part.spin_rate + turn) / 2;
    const double* p = q + quaternion(b);
    const Quat across = Quat(0, rise.x(), rise.y(), rise.z()) * quat(p);
    const double inward = part.spin.squaredNorm() / 4;
    double* a = out + quaternion(b);
    a[0] = across.w() - inward * p[0];
    a[1] = across.x() - inward * p[1];
    a[2] = across.y() - inward * p[2];
    a[3] = across.z() - inward * p[3];
  }
}

void System::solve_tensions() {
  links_.solve();
  if (!coupled_.empty()) add_couplings();
}

/// Solves the system and writes the accelerations that the tensions and the ends' leads cause.
void System::respond(const double* q, double* out) {
  if (rows_.empty()) {
    solve_tensions();
  } else {
    solve_with_rows(q);
  }
  links_.pull(q, out);
  if (!bodies_.empty()) move_bodies(q, out);
  if (!rows_.empty()) push_rows(q, out);
  for (const End& end : ends_) {
    links_.add(end.link, end.along,
               -end.pull * links_.inverse_rest(end.link) * end.free_acceleration, out);
  }
}

void System::clear_ends(double* array) const {
  std::fill_n(array, Links::kPad, 0.0);
  std::fill_n(array + size() - Links::kPad, Links::kPad, 0.0);
}

/// As of a chain in a plane, with a third component where it needs one; a body's matrices, and the
/// systems that several links at one body solve.
double System::count_cycles() const {
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  const double links = count(links_.count()), coupled = count(coupled_.size());
  return 450 + (plane_ ? 20 : 24) * links + 100 * count(ends_.size()) +
         200 * count(bodies_.size()) + coupled * (15 * links + 50) + coupled * coupled * coupled +
         count(rows_.size()) * (20 * links + 500);
}

void System::acceleration(double time, const double* q, const double* rate, double* out) {
  if (!bodies_.empty()) {
    turn_bodies(q, rate);
    lead_bodies();
  }
  read_holds(time);
  if (!rows_.empty()) {
    place(time, q, rate);
    evaluate_rows(time);
    lead_rows();
  }
  links_.assemble(q, rate);
  add_ends(q);
  respond(q, out);
  clear_ends(out);
}

bool System::retract(const double* base, double* x, double* rate) const {
  bool inside = links_.retract(base, x, rate);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::size_t k = quaternion(b);
    const Eigen::Map<const Eigen::Vector4d> o(base + k);
    Eigen::Map<Eigen::Vector4d> p(x + k), r(rate + k);
    p -= o.dot(p) * o;
    r -= o.dot(r) * o;
    const double room = 1 - p.squaredNorm();
    inside &= room > 0;
    const double w = std::sqrt(std::max(room, 1e-4));
    r -= p.dot(r) / w * o;
    p += w * o;
  }
  return inside;
}

void System::to_tangent(const double* base, double* x) const {
  links_.to_tangent(base, x);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Eigen::Map<const Eigen::Vector4d> o(base + quaternion(b));
    Eigen::Map<Eigen::Vector4d> p(x + quaternion(b));
    p -= o.dot(p) * o;
  }
}

void System::factor(double sigma_squared) {
  links_.factor(sigma_squared);
  factored_sigma_ = sigma_squared;
}

void System::solve_factored(double* x) const {
  links_.solve_factored(x);
  for (std::size_t k = quaternion(0); k < quaternion(bodies_.size()); ++k) x[k] /= factored_sigma_;
}

}  // namespace taut::direct
