// The state of a net: to and from the world, back to where it belongs, and its error.
#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/methods/direct/net.h"

namespace taut::direct {
namespace {

/// The rotation rate that gives `momentum`, least where the inertia leaves a choice (a straight
/// chain about its own line).
Vec3 spin_for(const Mat3& inertia, const Vec3& momentum) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double moment = eigen.eigenvalues()[k];
    const Vec3 axis = eigen.eigenvectors().col(k);
    if (moment > 1e-9 * eigen.eigenvalues()[2]) spin += axis.dot(momentum) / moment * axis;
  }
  return spin;
}

Mat3 point_inertia(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
}

}  // namespace

void Net::load(const World& world, std::vector<double>& q, std::vector<double>& rate) {
  attach(world);
  loaded_at_ = world.time;
  q.assign(size(), 0.0);
  rate.assign(size(), 0.0);
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    Vec3 u = world.gravity.norm() > 0 ? world.gravity.normalized() : Vec3::UnitX();
    for (std::size_t k = 0; k < span.links; ++k) {
      const std::size_t i = span.offset + k, a = span.particle(k), b = span.particle(k + 1);
      const Vec3 gap = connector.position[b] - connector.position[a];
      // Particles that coincide say nothing of the link between them: it goes on like the last.
      if (gap.norm() > 1e-9 * rest_[i]) u = gap.normalized();
      Vec3 turn = inverse_rest_[i] * (connector.velocity[b] - connector.velocity[a]);
      turn -= u.dot(turn) * u;
      add(q.data(), i, u);
      add(rate.data(), i, turn);
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = world.bodies[bodies_[b].body];
    const Quat turning = Quat(0, body.spin.x(), body.spin.y(), body.spin.z()) * body.rotation;
    double* p = q.data() + 3 * links_ + 4 * b;
    double* r = rate.data() + 3 * links_ + 4 * b;
    p[0] = body.rotation.w(), p[1] = body.rotation.x();
    p[2] = body.rotation.y(), p[3] = body.rotation.z();
    r[0] = turning.w() / 2, r[1] = turning.x() / 2;
    r[2] = turning.y() / 2, r[3] = turning.z() / 2;
  }

  if (floats_) {
    centre_ = {Vec3::Zero(), Vec3::Zero()};
    for (const Part& part : bodies_) {
      const Body& body = world.bodies[part.body];
      centre_.position += part.mass / mass_ * body.position;
      centre_.velocity += part.mass / mass_ * body.velocity;
    }
    std::size_t p = 0;
    for (const Span& span : spans_) {
      const Connector& connector = world.connectors[span.range.connector];
      for (std::size_t k = 0; k <= span.links; ++k, ++p) {
        centre_.position += particle_mass_[p] / mass_ * connector.position[span.particle(k)];
        centre_.velocity += particle_mass_[p] / mass_ * connector.velocity[span.particle(k)];
      }
    }
    place(world.time, q.data(), rate.data());
    spin_momentum_ = rotary(world.time).momentum;
  }
}

/// Fills points_ and centres_: everything's place and velocity at `time`.
void Net::place(double time, const double* q, const double* rate) {
  read_bodies(q, rate);
  const auto hang = [&](const End& end, const Point& point) {  // the body by one of its points
    centres_[end.body] = {point.position - end.arm,
                          point.velocity - bodies_[end.body].spin.cross(end.arm)};
  };
  if (floats_ && !bodies_.empty()) centres_[0] = {Vec3::Zero(), Vec3::Zero()};
  std::size_t p = 0;
  for (const Span& span : spans_) {
    Point point{Vec3::Zero(), Vec3::Zero()};
    if (span.first != kNone) {
      const End& end = ends_[span.first];
      if (end.body == kNone) {
        const PointMotion motion = hold_motion(*world_, end.to, time);
        point = {motion.position, motion.velocity};
      } else {
        point = {centres_[end.body].position + end.arm,
                 centres_[end.body].velocity + bodies_[end.body].spin.cross(end.arm)};
      }
    }
    points_[p++] = point;
    for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
      point.position += rest_[i] * at(q, i);
      point.velocity += rest_[i] * at(rate, i);
      points_[p++] = point;
    }
    if (!span.closes && span.last != kNone) hang(ends_[span.last], point);
  }
  if (!floats_) return;

  Point sum{Vec3::Zero(), Vec3::Zero()};
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    sum.position += bodies_[b].mass * centres_[b].position;
    sum.velocity += bodies_[b].mass * centres_[b].velocity;
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    sum.position += particle_mass_[k] * points_[k].position;
    sum.velocity += particle_mass_[k] * points_[k].velocity;
  }
  const double t = time - loaded_at_;
  const Vec3 shift =
      centre_.position + t * centre_.velocity + t * t / 2 * world_->gravity - sum.position / mass_;
  const Vec3 push = centre_.velocity + t * world_->gravity - sum.velocity / mass_;
  for (Point& point : points_) point = {point.position + shift, point.velocity + push};
  for (Point& point : centres_) point = {point.position + shift, point.velocity + push};
}

void Net::store(World& world, double time, const double* q, const double* rate) {
  attach(world);
  place(time, q, rate);
  std::size_t p = 0;
  for (const Span& span : spans_) {
    Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = 0; k <= span.links; ++k, ++p) {
      connector.position[span.particle(k)] = points_[p].position;
      connector.velocity[span.particle(k)] = points_[p].velocity;
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = world.bodies[bodies_[b].body];
    const double* r = q + 3 * links_ + 4 * b;
    body.position = centres_[b].position;
    body.velocity = centres_[b].velocity;
    body.rotation = Quat(r[0], r[1], r[2], r[3]);
    body.spin = bodies_[b].spin;
  }
}

void Net::project(double time, double* q, double* rate) {
  for (std::size_t i = 0; i < links_; ++i) {
    const Vec3 u = at(q, i), v = at(rate, i);
    const double scale = 1 / u.norm();
    const Vec3 unit = scale * u;
    add(q, i, unit - u);
    add(rate, i, -unit.dot(v) * unit);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Eigen::Map<Eigen::Vector4d> p(q + 3 * links_ + 4 * b), r(rate + 3 * links_ + 4 * b);
    p.normalize();
    r -= p.dot(r) * p;
  }
  close(time, q, rate);
  if (floats_) restore_momentum(time, q, rate);
}

/// Turns the links of every span that closes a loop by the least that brings its last point to its
/// place: u_i += l_i P_i c with P_i = 1 - u_i u_i', one 3x3 system for c; the same for the rates.
void Net::close(double time, double* q, double* rate) {
  constexpr int kRounds = 3;  // the first leaves the square of the gap, the second rounding
  for (int round = 0; round < kRounds; ++round) {
    bool any = false;
    for (const Span& span : spans_) any |= span.closes;
    if (!any) return;
    place(time, q, rate);
    std::size_t p = 0;
    for (const Span& span : spans_) {
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
      Mat3 system = Mat3::Zero();
      for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
        const Vec3 u = at(q, i);
        system += rest_[i] * rest_[i] * (Mat3::Identity() - u * u.transpose());
      }
      system += 1e-14 * system.trace() * Mat3::Identity();  // a straight span cannot give way along
      const Eigen::PartialPivLU<Mat3> solver(system);
      const Vec3 shift = solver.solve(goal.position - points_[p - 1].position);
      const Vec3 push = solver.solve(goal.velocity - points_[p - 1].velocity);
      for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
        const Vec3 u = at(q, i), v = at(rate, i);
        const Vec3 unit = (u + rest_[i] * (shift - u.dot(shift) * u)).normalized();
        const Vec3 turn = v + rest_[i] * push;
        add(q, i, unit - u);
        add(rate, i, turn - unit.dot(turn) * unit - v);
      }
    }
  }
}

/// Angular momentum and inertia about the centre of mass; points_ and centres_ are up to date.
Net::Rotary Net::rotary(double time) const {
  const double t = time - loaded_at_;
  const Point mean{centre_.position + t * centre_.velocity + t * t / 2 * world_->gravity,
                   centre_.velocity + t * world_->gravity};
  Rotary sum;
  const auto count = [&](double mass, const Point& point) {
    const Vec3 r = point.position - mean.position;
    sum.momentum += mass * r.cross(point.velocity - mean.velocity);
    sum.inertia += point_inertia(mass, r);
  };
  for (std::size_t k = 0; k < points_.size(); ++k) count(particle_mass_[k], points_[k]);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    count(part.mass, centres_[b]);
    const Mat3 own = part.rotation * part.inertia * part.rotation.transpose();
    sum.momentum += own * part.spin;
    sum.inertia += own;
  }
  return sum;
}

/// Gives a floating net its angular momentum back by one rigid rotation.
void Net::restore_momentum(double time, double* q, double* rate) {
  place(time, q, rate);
  const Rotary now = rotary(time);
  const Vec3 spin = spin_for(now.inertia, spin_momentum_ - now.momentum);
  for (std::size_t i = 0; i < links_; ++i) add(rate, i, spin.cross(at(q, i)));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* p = q + 3 * links_ + 4 * b;
    const Quat turn = Quat(0, spin.x(), spin.y(), spin.z()) * Quat(p[0], p[1], p[2], p[3]);
    double* r = rate + 3 * links_ + 4 * b;
    r[0] += turn.w() / 2, r[1] += turn.x() / 2;
    r[2] += turn.y() / 2, r[3] += turn.z() / 2;
  }
}

double Net::error(const double*, const double* eq, const double* er) const {
  double sum = 0;
  std::size_t count = 0;
  for (const Span& span : spans_) {
    Vec3 shift = Vec3::Zero(), push = Vec3::Zero();
    for (std::size_t i = span.offset; i < span.offset + span.links; ++i) {
      shift += rest_[i] * at(eq, i);
      push += rest_[i] * at(er, i);
      sum += shift.squaredNorm() + memory_ * memory_ * push.squaredNorm();
    }
    count += span.links;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    double turn = 0;
    for (std::size_t c = 3 * links_ + 4 * b; c < 3 * links_ + 4 * b + 4; ++c) {
      turn += eq[c] * eq[c] + memory_ * memory_ * er[c] * er[c];
    }
    sum += 4 * turn * part.inertia.trace() / (2 * part.mass);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace taut::direct
