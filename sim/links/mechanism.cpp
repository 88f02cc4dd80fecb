#include "sim/links/mechanism.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut {
namespace {

Eigen::Map<Vec3> vector(double* at) {
  return Eigen::Map<Vec3>(at);
}
Eigen::Map<const Vec3> vector(const double* at) {
  return Eigen::Map<const Vec3>(at);
}

constexpr double kBeyondSense = 100;  // times the rest length

}  // namespace

Quat quaternion(const double* q) {
  return Quat(q[0], q[1], q[2], q[3]);
}

void set_quaternion(const Quat& rotation, double* q) {
  q[0] = rotation.w();
  vector(q + 1) = rotation.vec();
}

void rotate(const Vec3& angle, double* q) {
  const double half = 0.5 * angle.norm();
  // sin(x)/x by its series where x is so small that the rest is below rounding.
  const double sinc = half > 1e-4 ? std::sin(half) / half : 1 - half * half / 6;
  Quat turn;
  turn.w() = std::cos(half);
  turn.vec() = 0.5 * sinc * angle;
  set_quaternion((turn * quaternion(q)).normalized(), q);
}

Vec3 angle(const Quat& rotation) {
  const double sine = rotation.vec().norm();
  if (sine == 0) return Vec3::Zero();
  const double towards = rotation.w() < 0 ? -1 : 1;  // the shorter way round
  return 2 * towards * std::atan2(sine, std::abs(rotation.w())) / sine * rotation.vec();
}

void Mechanism::load(const World& world, std::vector<double>& state) {
  world_ = &world;
  material_.load_twists(world);
  state.resize(state_size());
  std::size_t point = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i, ++point) {
      vector(&state[position(point)]) = connector.position[i];
      vector(&state[velocity(point)]) = connector.velocity[i];
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = world.bodies[body_index_[b]];
    double* q = &state[pose(b)];
    vector(q) = body.position;
    set_quaternion(body.rotation, q + 3);
    double* u = &state[twist(b)];
    vector(u) = body.velocity;
    vector(u + 3) = body.spin;
  }
  for (std::size_t p = 0; p < pulleys(); ++p) {
    state[passed(p)] = world.pulleys[p].passed;
    state[speed(p)] = world.pulleys[p].speed;
  }
}

void Mechanism::store(const std::vector<double>& state, double time, World& world) const {
  std::size_t point = 0;
  for (Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i, ++point) {
      connector.position[i] = vector(&state[position(point)]);
      connector.velocity[i] = vector(&state[velocity(point)]);
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = world.bodies[body_index_[b]];
    const double* q = &state[pose(b)];
    body.position = vector(q);
    body.rotation = quaternion(q + 3);
    const double* u = &state[twist(b)];
    body.velocity = vector(u);
    body.spin = vector(u + 3);
  }
  for (std::size_t p = 0; p < pulleys(); ++p) {
    world.pulleys[p].passed = state[passed(p)];
    world.pulleys[p].speed = state[speed(p)];
  }
  material_.store_twists(world);
  place_held(world, time);
}

void Mechanism::follow(double time, const std::vector<double>& state) {
  if (material_.twists().empty()) return;
  material_.place(*world_, time);
  material_.follow(state.data());
}

std::optional<Mechanism::ClampOnBody> Mechanism::clamp_on_body(
    const material::BendElement& bend) const {
  for (const auto& at : material_.body_clamps()) {
    if (at.clamp == bend.clamp) {
      return ClampOnBody{static_cast<std::uint32_t>(free_index_[at.body]),
                         material_.direction(at.clamp)};
    }
  }
  return {};
}

void Mechanism::update(double time, double* state) {
  place(time, state);
  if (material_.any() || has_winches()) add_forces(state);
  measure(state);
  if (pulleys() > 0) measure_pulleys(state);
}

void Mechanism::place(double time, double* state) {
  for (const auto& [point, hold] : prescribed_) {
    const PointMotion motion = hold_motion(*world_, hold, time);
    vector(state + position(point)) = motion.position;
    vector(state + velocity(point)) = motion.velocity;
    point_acceleration_[point] = motion.acceleration;
  }
  if (material_.any()) material_.place(*world_, time);
  for (const auto& at : material_.body_clamps()) {
    const std::size_t body = free_index_[at.body];
    const Vec3 direction = quaternion(state + pose(body) + 3).normalized() * at.direction;
    material_.turn(at.clamp, {direction, vector(state + twist(body) + 3).cross(direction)});
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    FreeBody& body = bodies_[b];
    const Mat3 turn = quaternion(state + pose(b) + 3).normalized().toRotationMatrix();
    const Vec3 spin = vector(state + twist(b) + 3);
    body.world_inverse = turn * body.inverse_inertia * turn.transpose();
    const Vec3 angular_momentum = turn * (body.inertia * (turn.transpose() * spin));
    body.gyration = body.world_inverse * angular_momentum.cross(spin);
  }
  for (BodyPoint& carried : body_points_) {
    const double* q = state + pose(carried.body);
    const double* u = state + twist(carried.body);
    const Vec3 spin = vector(u + 3);
    carried.arm = quaternion(q + 3).normalized() * carried.local;
    vector(state + position(carried.point)) = vector(q) + carried.arm;
    vector(state + velocity(carried.point)) = vector(u) + spin.cross(carried.arm);
    point_acceleration_[carried.point] = gravity_ +
                                         bodies_[carried.body].gyration.cross(carried.arm) +
                                         spin.cross(spin.cross(carried.arm));
  }
  for (const auto& [point, leads] : joined_) {
    vector(state + position(point)) = vector(state + position(leads));
    vector(state + velocity(point)) = vector(state + velocity(leads));
  }
  if (has_winches()) place_winches(time, state);
}

/// After place(): adds what the forces of materials and of their flow do to points and bodies.
void Mechanism::add_forces(const double* state) {
  std::ranges::fill(force_, Vec3::Zero());
  material_.add(state, state + velocities_, force_);
  if (has_winches()) add_flow(state, force_);
  for (std::size_t i = 0; i < points(); ++i) {
    if (inverse_mass_[i] != 0) point_acceleration_[i] = gravity_ + inverse_mass_[i] * force_[i];
  }
  std::ranges::fill(body_push_, BodyPush());
  for (const BodyPoint& carried : body_points_) {
    const FreeBody& body = bodies_[carried.body];
    const Vec3& force = force_[carried.point];
    body_push_[carried.body].linear += body.inverse_mass * force;
    body_push_[carried.body].angular += body.world_inverse * carried.arm.cross(force);
  }
  for (const BodyPoint& carried : body_points_) {
    const BodyPush& push = body_push_[carried.body];
    point_acceleration_[carried.point] += push.linear + push.angular.cross(carried.arm);
  }
}

void Mechanism::measure(const double* state) {
  const double* velocities = state + velocities_;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const Vec3 gap = vector(state + 3 * row.b) - vector(state + 3 * row.a);
    const Vec3 gap_rate = vector(velocities + 3 * row.b) - vector(velocities + 3 * row.a);
    if (row.axis != Row::kAlongLink) {
      direction_[r] = Vec3::Unit(row.axis);
      violation_[r] = gap[row.axis];
      rate_[r] = gap_rate[row.axis];
      velocity_term_[r] = 0;
      continue;
    }
    const double length = gap.norm();
    const double inverse = length > 0 ? 1 / length : 0;
    direction_[r] = inverse * gap;
    violation_[r] = length - row.rest;
    rate_[r] = direction_[r].dot(gap_rate);
    velocity_term_[r] = (gap_rate - rate_[r] * direction_[r]).squaredNorm() * inverse;
  }
  if (has_winches()) measure_winches();
}

void Mechanism::differentiate(const double* state, const double* tension,
                              double* derivative) const {
  const std::size_t p = points();
  double* acceleration = derivative + velocities_;
  std::copy_n(state + velocities_, 3 * p, derivative);
  for (std::size_t i = 0; i < p; ++i) vector(acceleration + 3 * i) = gravity_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double* u = state + twist(b);
    double* pose_rate = derivative + pose(b);
    vector(pose_rate) = vector(u);
    const Quat spin(0, 0.5 * u[3], 0.5 * u[4], 0.5 * u[5]);
    const Quat turning = spin * quaternion(state + pose(b) + 3);
    set_quaternion(turning, pose_rate + 3);
    vector(derivative + twist(b)) = gravity_;
    vector(derivative + twist(b) + 3) = bodies_[b].gyration;
  }
  for (std::size_t i = 0; i < pulleys(); ++i) {
    derivative[passed(i)] = state[speed(i)];
    derivative[speed(i)] = 0;
  }
  if (material_.any() || has_winches()) {
    for (std::size_t i = 0; i < p; ++i) vector(acceleration + 3 * i) = point_acceleration_[i];
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      vector(derivative + twist(b)) += body_push_[b].linear;
      vector(derivative + twist(b) + 3) += body_push_[b].angular;
    }
  }
  push(tension, derivative);
  const auto rest = [&](std::size_t point) {
    vector(derivative + position(point)).setZero();
    vector(derivative + velocity(point)).setZero();
  };
  for (const auto& held : prescribed_) rest(held.first);
  for (const BodyPoint& carried : body_points_) rest(carried.point);
  for (const auto& joined : joined_) rest(joined.first);
}

void Mechanism::push(const double* impulse, double* state) const {
  double* velocities = state + velocities_;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const Vec3 pull = impulse[r] * direction_[r];
    vector(velocities + 3 * row.a) += inverse_mass_[row.a] * pull;
    vector(velocities + 3 * row.b) -= inverse_mass_[row.b] * pull;
  }
  for (const RowEnd& end : row_ends_) {
    const BodyPoint& carried = body_points_[end.body_point];
    const FreeBody& body = bodies_[carried.body];
    const Vec3 pull = end.sign * impulse[end.row] * direction_[end.row];
    double* u = state + twist(carried.body);
    vector(u) += body.inverse_mass * pull;
    vector(u + 3) += body.world_inverse * carried.arm.cross(pull);
  }
  if (pulleys() == 0) return;
  const double* by = impulse + rows_.size();
  push_pulleys(by, velocities, state + speed(0));
  for (std::size_t p = 0; p < pulleys(); ++p) {
    for (const RopeEnd& end : pulleys_[p].end) {
      for (const auto& [body, push] : end.pushes) {
        vector(state + twist(body)) += by[p] * push.linear;
        vector(state + twist(body) + 3) += by[p] * push.angular;
      }
    }
  }
}

void Mechanism::move(const double* shift, double* state) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const Vec3 pull = shift[r] * direction_[r];
    vector(state + 3 * row.a) += inverse_mass_[row.a] * pull;
    vector(state + 3 * row.b) -= inverse_mass_[row.b] * pull;
  }
  for (const RowEnd& end : row_ends_) {
    const BodyPoint& carried = body_points_[end.body_point];
    const FreeBody& body = bodies_[carried.body];
    const Vec3 pull = end.sign * shift[end.row] * direction_[end.row];
    double* q = state + pose(carried.body);
    vector(q) += body.inverse_mass * pull;
    rotate(body.world_inverse * carried.arm.cross(pull), q + 3);
  }
  if (pulleys() == 0) return;
  const double* by = shift + rows_.size();
  push_pulleys(by, state, state + passed(0));
  for (std::size_t p = 0; p < pulleys(); ++p) {
    for (const RopeEnd& end : pulleys_[p].end) {
      for (const auto& [body, push] : end.pushes) {
        vector(state + pose(body)) += by[p] * push.linear;
        rotate(by[p] * push.angular, state + pose(body) + 3);
      }
    }
  }
}

std::optional<Mechanism::Link> Mechanism::broken_link(const double* state) const {
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Row& row = rows_[r];
    const double squared = (vector(state + 3 * row.b) - vector(state + 3 * row.a)).squaredNorm();
    const double longest = kBeyondSense * row.rest;
    const double bound = row.rest > 0 ? longest * longest : std::numeric_limits<double>::max();
    if (!(squared <= bound)) return Link{row.connector, row.link};  // not finite fails too
  }
  for (const material::StretchElement& link : material_.stretches()) {
    const double squared = (vector(state + 3 * link.b) - vector(state + 3 * link.a)).squaredNorm();
    if (!std::isfinite(squared)) return Link{link.connector, link.link};
  }
  return std::nullopt;
}

}  // namespace taut
