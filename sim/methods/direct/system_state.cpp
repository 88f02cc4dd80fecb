// The state of a system, from and to the world.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/system.h"

namespace taut::direct {
namespace {

/// The rotation rate that gives `momentum`, least where the inertia leaves a choice (a straight
/// chain about its own line).
Vec3 spin_for(const Mat3& inertia, const Vec3& momentum) {
  constexpr double kNone = 1e-9;  // of the largest moment
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double moment = eigen.eigenvalues()[k];
    const Vec3 axis = eigen.eigenvectors().col(k);
    if (moment > kNone * eigen.eigenvalues()[2]) spin += axis.dot(momentum) / moment * axis;
  }
  return spin;
}

void put(const Vec3& vector, double* c) {
  c[0] = vector.x(), c[1] = vector.y(), c[2] = vector.z();
}

void put(const Quat& q, double* c) {
  c[0] = q.w(), c[1] = q.x(), c[2] = q.y(), c[3] = q.z();
}

Quat half_turning(const Vec3& spin, const Quat& rotation) {
  return Quat(0, spin.x() / 2, spin.y() / 2, spin.z() / 2) * rotation;
}

}  // namespace

void System::load(const World& world, double* q, double* v) {
  attach(world);
  left_plane_.reset();
  std::fill_n(q, size(), 0.0);
  std::fill_n(v, size(), 0.0);
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = span.range.first; k <= span.range.last; ++k) {
      const std::size_t point = point_of_[span.first_particle + k - span.range.first];
      set(q, point, connector.position[k]);
      set(v, point, connector.velocity[k]);
    }
    if (plane_) offset_ = connector.position[span.range.first].dot(plane_->normal);
  }
  for (Bar& bar : bars_) {
    const Body& body = world.bodies[bar.body];
    const Vec3 tip = place_of(q, bar.tip);
    bar.direction = (body.position - tip).normalized();
    bar.rotation = body.rotation;
    const double reach = link_length(bar);
    set(q, bar.far, at(q, bar.tip) + reach * bar.direction);
    set(v, bar.far, at(v, bar.tip) + reach * body.spin.cross(bar.direction));
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = world.bodies[bodies_[b].body];
    put(body.position, q + body_at(b));
    put(body.rotation, q + body_at(b) + 3);
    put(body.velocity, v + body_at(b));
    put(half_turning(body.spin, body.rotation), v + body_at(b) + 3);
  }
  if (!floats_) return;
  spin_momentum_.setZero();
  place(world.time, q, v);
  spin_momentum_ = rotary(q, v).momentum;
}

void System::store(World& world, double* q, double* v) {
  attach(world);
  place(world.time, q, v);
  for (const Span& span : spans_) {
    Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = span.range.first; k <= span.range.last; ++k) {
      const std::size_t point = point_of_[span.first_particle + k - span.range.first];
      if (held_[point] && (k == span.range.first || k == span.range.last)) continue;
      connector.position[k] = place_of(q, point);
      connector.velocity[k] = at(v, point);
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = world.bodies[bodies_[b].body];
    const double *x = q + body_at(b), *rate = v + body_at(b);
    body.position = Vec3(x[0], x[1], x[2]);
    body.velocity = Vec3(rate[0], rate[1], rate[2]);
    body.rotation = Quat(x[3], x[4], x[5], x[6]);
    body.spin = bodies_[b].spin;
  }
  store_bars(world, q, v);
}

void System::store_bars(World& world, const double* q, const double* v) const {
  for (const Bar& bar : bars_) {
    const double per_reach = 1 / link_length(bar);
    const Vec3 now = per_reach * (at(q, bar.far) - at(q, bar.tip));
    const Vec3 rate = per_reach * (at(v, bar.far) - at(v, bar.tip));
    const double angle =
        std::atan2(bar.direction.cross(now).dot(plane_->normal), bar.direction.dot(now));
    Body& body = world.bodies[bar.body];
    body.position = place_of(q, bar.tip) + bar.arm * now;
    body.velocity = at(v, bar.tip) + bar.arm * rate;
    body.rotation = Quat(Eigen::AngleAxisd(angle, plane_->normal)) * bar.rotation;
    body.spin = now.cross(rate);
  }
}

/// Momentum and inertia about the centre of mass.
System::Rotary System::rotary(const double* q, const double* v) const {
  const auto each = [&](auto visit) {
    for (std::size_t k = 0; k < points_; ++k) visit(point_mass_[k], at(q, k), at(v, k));
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const double *x = q + body_at(b), *rate = v + body_at(b);
      visit(bodies_[b].mass, Vec3(x[0], x[1], x[2]), Vec3(rate[0], rate[1], rate[2]));
    }
  };
  Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero();
  each([&](double mass, const Vec3& x, const Vec3& rate) {
    centre += mass / mass_ * x;
    velocity += mass / mass_ * rate;
  });
  Rotary sum;
  sum.centre = centre;
  each([&](double mass, const Vec3& x, const Vec3& rate) {
    const Vec3 r = x - centre;
    sum.momentum += mass * r.cross(rate - velocity);
    sum.inertia += mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  });
  for (const RigidBody& body : bodies_) {
    const Mat3 own = body.rotation * body.inertia * body.rotation.transpose();
    sum.momentum += own * body.spin;
    sum.inertia += own;
  }
  return sum;
}

/// Gives a floating component its angular momentum back by one rigid rotation.
void System::keep_angular_momentum(double* q, double* v) {
  turn_bodies(q, v);
  const Rotary now = rotary(q, v);
  const Vec3 spin = spin_for(now.inertia, spin_momentum_ - now.momentum);
  for (std::size_t k = 0; k < points_; ++k) set(v, k, at(v, k) + spin.cross(at(q, k) - now.centre));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* x = q + body_at(b);
    double* rate = v + body_at(b);
    const Vec3 push = spin.cross(Vec3(x[0], x[1], x[2]) - now.centre);
    rate[0] += push.x(), rate[1] += push.y(), rate[2] += push.z();
    const Quat turn = half_turning(spin, Quat(x[3], x[4], x[5], x[6]));
    rate[3] += turn.w(), rate[4] += turn.x(), rate[5] += turn.y(), rate[6] += turn.z();
  }
}

}  // namespace taut::direct
