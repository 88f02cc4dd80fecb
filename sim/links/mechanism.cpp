#include "sim/links/mechanism.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/material/elements.h"
#include "sim/topology/components.h"

namespace taut {
namespace {

Eigen::Map<Vec3> vector(double* at) {
  return Eigen::Map<Vec3>(at);
}
Eigen::Map<const Vec3> vector(const double* at) {
  return Eigen::Map<const Vec3>(at);
}

constexpr double kMassless = -1;      // in the place of an inverse mass
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

// How a mechanism lays a world out: points, bodies, rows and forces, in room for what may join.

void Mechanism::rebuild(const World& world) {
  gravity_ = world.gravity;
  reserve(world);
  add_bodies(world);
  add_points(world);
  velocities_ = 3 * points() + 7 * bodies_.size() + world.pulleys.size();
  twists_ = velocities_ + 3 * points();
  add_rows(world);
  add_row_ends();
  material_.rebuild(world, room_, leaders_);
  add_winches(world);
  find_winched_joints(world);
  add_pulleys(world);
  if (material_.any() || has_winches()) {
    force_.reserve(room_);
    force_.resize(points());
    body_push_.resize(bodies_.size());
  }
  point_acceleration_.assign(points(), gravity_);
  direction_.resize(rows_.size());
  violation_.resize(rows_.size());
  rate_.resize(rows_.size());
  velocity_term_.resize(rows_.size());
}

void Mechanism::reserve(const World& world) {
  std::size_t points = 0, joints = 0;
  for (const Connector& connector : world.connectors) {
    points += connector.particles();
    for (const double rest : connector.rest) joints += rest > 0 ? 0 : 1;
  }
  if (room_ > 0 && points <= room_) return;
  const Room all = room(world);
  room_ = all.particles;
  inverse_mass_.reserve(room_);
  point_acceleration_.reserve(room_);
  body_points_.reserve(all.holds);
  prescribed_.reserve(all.holds);
  row_ends_.reserve(2 * all.holds);
  const std::size_t rows = room_ + 2 * joints;
  rows_.reserve(rows);
  direction_.reserve(rows);
  violation_.reserve(rows);
  rate_.reserve(rows);
  velocity_term_.reserve(rows);
}

void Mechanism::add_bodies(const World& world) {
  free_index_.resize(world.bodies.size());
  body_index_.clear();
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const Body& body = world.bodies[b];
    if (body.driven()) continue;
    const std::size_t index = body_index_.size();
    free_index_[b] = index;
    body_index_.push_back(b);
    if (index == bodies_.size()) bodies_.emplace_back();
    const MassProperties& mass = body.mass_properties;
    FreeBody& made = bodies_[index];
    made.inverse_mass = 1 / mass.mass;
    if (made.inertia == mass.inertia) continue;  // as before
    made.inertia = mass.inertia;
    made.rotation = FreeRotation(mass.inertia);
    made.inverse_inertia = made.rotation.inverse_inertia(Quat::Identity());
  }
  bodies_.resize(body_index_.size());
}

void Mechanism::add_points(const World& world) {
  inverse_mass_.clear();
  body_points_.clear();
  prescribed_.clear();
  for (const Connector& connector : world.connectors) {
    const std::size_t first = inverse_mass_.size();
    for (const double mass : connector.particle_mass) {
      inverse_mass_.push_back(mass > 0 ? 1 / mass : kMassless);
    }
    for (const Hold& hold : connector.holds) {
      const std::uint32_t point = small(first + hold.particle);
      inverse_mass_[point] = 0;
      if (is_prescribed(world, hold.to)) {
        prescribed_.emplace_back(point, hold.to);
      } else {
        const Vec3 centre = world.bodies[hold.to.body].mass_properties.centre;
        body_points_.push_back({.point = point,
                                .body = small(free_index_[hold.to.body]),
                                .local = hold.to.point - centre});
      }
    }
  }
  join_points(world);
  if (std::ranges::find(inverse_mass_, kMassless) != inverse_mass_.end()) {
    throw std::invalid_argument("a particle that nothing holds needs a mass");
  }
}

void Mechanism::join_points(const World& world) {
  joined_.clear();
  leaders_.clear();
  if (world.joints.empty()) return;
  find_leaders(world, leaders_);
  std::vector<double> mass;
  for (const Connector& connector : world.connectors) {
    mass.insert(mass.end(), connector.particle_mass.begin(), connector.particle_mass.end());
  }
  for (std::uint32_t p = 0; p < points(); ++p) {
    const std::uint32_t leads = leaders_[p];
    if (leads == p) continue;
    joined_.emplace_back(p, leads);
    inverse_mass_[p] = 0;
    mass[leads] += mass[p];
    if (inverse_mass_[leads] != 0) inverse_mass_[leads] = 1 / mass[leads];
  }
}

void Mechanism::add_rows(const World& world) {
  rows_.clear();
  has_strings_ = taut::has_strings(world);
  std::size_t first = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t rows = connector.stretches() ? 0 : connector.links();
    for (std::size_t k = 0; k < rows; ++k) {
      const double rest = connector.rest[k];
      const int axes = rest > 0 ? 1 : 3;
      for (int axis = 0; axis < axes; ++axis) {
        rows_.push_back({.a = small(first + k),
                         .b = small(first + k + 1),
                         .rest = rest,
                         .axis = rest > 0 ? Row::kAlongLink : axis,
                         .pulls = connector.pulls && rest > 0,
                         .connector = small(c),
                         .link = small(k)});
      }
    }
    first += connector.particles();
  }
  if (!is_joined()) return;
  for (Row& row : rows_) {
    row.a = leaders_[row.a];
    row.b = leaders_[row.b];
  }
}

void Mechanism::add_winches(const World& world) {
  winches_.clear();
  std::size_t first = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.winch) {
      const auto index = [](const auto& all, auto found) {
        return small(static_cast<std::size_t>(found - all.begin()));
      };
      Winched added{.winch = connector.winch, .connector = small(c), .first_point = small(first)};
      if (connector.stretches()) {
        const auto& links = material_.stretches();
        added.first_stretch =
            index(links, std::ranges::find(links, small(c), &material::StretchElement::connector));
        added.squared_stretch.assign(connector.links(), 1.0);
      } else {
        added.first_row = index(rows_, std::ranges::find(rows_, small(c), &Row::connector));
      }
      const auto& drags = material_.drags();
      const auto drag = std::ranges::find(drags, small(first), &material::DragElement::a);
      if (drag != drags.end()) added.first_drag = index(drags, drag);
      const auto& bends = material_.bends();
      const auto point = &material::BendElement::b;
      added.first_bend = index(bends, std::ranges::lower_bound(bends, first, {}, point));
      added.bends_end =
          index(bends, std::ranges::lower_bound(bends, first + connector.particles(), {}, point));
      winches_.push_back(std::move(added));
    }
    first += connector.particles();
  }
}

/// Joints of which a particle is of a connector with a winch: the others keep their masses.
void Mechanism::find_winched_joints(const World& world) {
  winched_leaders_.clear();
  is_winched_group_.assign(is_joined() ? points() : 0, 0);
  kept_mass_.assign(is_winched_group_.size(), 0.0);
  joined_mass_ = kept_mass_;
  if (!is_joined() || winches_.empty()) return;
  std::vector<double> mass;
  std::vector<char> winched;
  for (const Connector& connector : world.connectors) {
    mass.insert(mass.end(), connector.particle_mass.begin(), connector.particle_mass.end());
    winched.insert(winched.end(), connector.particles(), connector.winch != nullptr);
  }
  const auto note = [&](std::uint32_t point, std::uint32_t leads) {
    if (winched[point] == 0) {
      kept_mass_[leads] += mass[point];
    } else if (is_winched_group_[leads] == 0) {
      is_winched_group_[leads] = 1;
      winched_leaders_.push_back(leads);
    }
  };
  std::uint32_t noted = 0xffffffff;
  auto groups = joined_;
  std::ranges::sort(groups, {}, [](const auto& joined) { return joined.second; });
  for (const auto& [point, leads] : groups) {
    if (leads != noted) note(leads, leads);
    noted = leads;
    note(point, leads);
  }
}

void Mechanism::add_row_ends() {
  row_ends_.clear();
  if (body_points_.empty()) return;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (inverse_mass_[rows_[r].a] != 0 && inverse_mass_[rows_[r].b] != 0) continue;  // both free
    for (std::size_t i = 0; i < body_points_.size(); ++i) {
      const auto point = body_points_[i].point;
      if (rows_[r].a == point) row_ends_.push_back({small(r), small(i), 1.0});
      if (rows_[r].b == point) row_ends_.push_back({small(r), small(i), -1.0});
    }
  }
}

// Its state, and the motion from that.

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
                         material_.direction(at.clamp), at.direction};
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
  for (const auto& at : material_.body_clamps()) {
    const std::size_t body = free_index_[at.body];
    material_.each_bend_at(at, [&](std::size_t index) {
      const material::BendElement& bend = material_.bends()[index];
      Vec3 by_e0, by_e1;
      material_.slope(bend, state, state + velocities_, by_e0, by_e1);
      const Vec3 force = bend.clamped_before() ? by_e0 : by_e1;  // against that on its edge
      body_push_[body].angular -=
          bodies_[body].world_inverse * material_.direction(at.clamp).cross(force);
    });
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

// How a mechanism pays rope out: winches, as the time tells, and pulleys, as they turn.

namespace {

/// The share of the length paid out at an end (first 0, last 1) that passes a particle, forwards.
double flow_share(const Winch& winch, std::size_t end, std::size_t particle) {
  return end == 0 ? 1 - winch.before[particle] : -winch.before[particle];
}

}  // namespace

void Mechanism::place_winches(double time, const double* state) {
  for (Winched& at : winches_) {
    at.first = at.winch->paid_out(0, time);
    at.last = at.winch->paid_out(1, time);
  }
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const PaidOut moved{state[passed(p)], state[speed(p)]};
    PaidOut& first = winches_[pulleys_[p].end[1].winched].first;
    PaidOut& last = winches_[pulleys_[p].end[0].winched].last;
    first = first + moved;
    last = last + PaidOut{-moved.length, -moved.rate};
  }
  for (const std::uint32_t leads : winched_leaders_) joined_mass_[leads] = kept_mass_[leads];
  for (Winched& at : winches_) {
    const Winch& winch = *at.winch;
    at.longer = at.first + at.last;
    const double longer = at.longer.length;
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      const double rest = winch.rest[k] + winch.share(k) * longer;
      if (at.first_stretch) {
        material_.pay_out(*at.first_stretch + k, rest, winch.share(k) * at.longer.rate);
      } else {
        rows_[at.first_row + k].rest = rest;
      }
      if (material_.any()) material_.set_rest(at.first_point + small(k), rest);
      if (!at.first_drag) continue;
      const double speed =
          winch.flow(k, at.first, at.last).speed + winch.flow(k + 1, at.first, at.last).speed;
      material_.flow_past(*at.first_drag + k, rest, speed / 2);
    }
    material_.bend_over_lengths(at.first_bend, at.bends_end);
    for (std::size_t i = 0; i < winch.particle_mass.size(); ++i) {
      const std::size_t point = at.first_point + i;
      const double mass = winch.particle_mass[i] + winch.density * winch.share_at(i) * longer;
      if (is_joined() && is_winched_group_[leaders_[point]] != 0) {
        joined_mass_[leaders_[point]] += mass;
      } else if (inverse_mass_[point] != 0) {
        inverse_mass_[point] = 1 / mass;
      }
    }
  }
  for (const std::uint32_t leads : winched_leaders_) {
    if (inverse_mass_[leads] != 0) inverse_mass_[leads] = 1 / joined_mass_[leads];
  }
}

void Mechanism::add_flow(const double* state, std::vector<Vec3>& force) const {
  const double* velocities = state + velocities_;
  for (const Winched& at : winches_) {
    const Winch& winch = *at.winch;
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      const std::size_t a = at.first_point + k, b = a + 1;
      const Winch::Flow before = winch.flow(k, at.first, at.last),
                        behind = winch.flow(k + 1, at.first, at.last);
      const Vec3 gap = vector(state + 3 * b) - vector(state + 3 * a);
      const Vec3 turned =
          (before.speed + behind.speed) * (vector(velocities + 3 * b) - vector(velocities + 3 * a));
      force[leader(a)] -= winch.density / 2 * (turned + before.rate * gap);
      force[leader(b)] -= winch.density / 2 * (turned + behind.rate * gap);
      if (!at.first_stretch) continue;
      // The tension of a rigid link contains this force.
      const double squares = before.speed * before.speed + behind.speed * behind.speed;
      const Vec3 along = winch.density / 2 * squares / rest_of(at, k) * gap;
      force[leader(a)] -= along;
      force[leader(b)] += along;
    }
  }
}

/// The velocity of rope that flows past a particle at 1 m/s of its unstretched length: along either
/// link it has the speed of what flows there, so that no link is stretched where rope sticks to a
/// drum. Where links meet at less than a right angle it is no faster.
Vec3 Mechanism::way_at(const Winched& at, std::size_t particle, const double* state) const {
  const auto strained = [&](std::size_t link) {
    const Vec3 gap = vector(state + position(at.first_point + link + 1)) -
                     vector(state + position(at.first_point + link));
    return Vec3(gap / rest_of(at, link));
  };
  if (particle == 0) return strained(0);
  const Vec3 before = strained(particle - 1);
  if (particle == at.winch->rest.size()) return before;
  const Vec3 behind = strained(particle);
  const double stretch = (before.norm() + behind.norm()) / 2;
  const Vec3 u = before.stableNormalized(), w = behind.stableNormalized();
  return stretch / std::max(1 + u.dot(w), 1.0) * (u + w);
}

Vec3 Mechanism::flow_past(std::size_t point, const double* state) const {
  for (const Winched& at : winches_) {
    if (point < at.first_point || point > at.first_point + at.winch->rest.size()) continue;
    const std::size_t i = point - at.first_point;
    return at.winch->flow(i, at.first, at.last).speed * way_at(at, i, state);
  }
  return Vec3::Zero();
}

Vec3 Mechanism::flow_by(std::size_t pulley, std::size_t side, std::size_t point,
                        const double* state) const {
  const Winched& at = winches_[pulleys_[pulley].end[side].winched];
  if (point < at.first_point || point > at.first_point + at.winch->rest.size()) {
    return Vec3::Zero();
  }
  const std::size_t i = point - at.first_point;
  const double pays = side == 0 ? -1 : 1;  // of the end at the pulley
  return pays * flow_share(*at.winch, 1 - side, i) * way_at(at, i, state);
}

/// Beside measure(): rest lengths change.
void Mechanism::measure_winches() {
  for (const Winched& at : winches_) {
    for (std::size_t k = 0; !at.first_stretch && k < at.winch->rest.size(); ++k) {
      rate_[at.first_row + k] -= at.winch->share(k) * at.longer.rate;
      velocity_term_[at.first_row + k] -= at.winch->share(k) * at.longer.acceleration;
    }
  }
}

/// By how much (N) the energy of bends falls with what a connector pays out.
double Mechanism::bending_force(const Winched& at, const double* state) const {
  double sum = 0;
  Vec3 e0, e1;
  for (std::size_t b = at.first_bend; b < at.bends_end; ++b) {
    const material::BendElement& bend = material_.bends()[b];
    material_.edges(bend, state, e0, e1);
    const std::size_t particle = bend.b - at.first_point;
    double length = 0, share = 0;  // of half of either link
    const auto add = [&](std::size_t link) {
      length += rest_of(at, link) / 2;
      share += at.winch->share(link) / 2;
    };
    if (!bend.clamped_before()) add(particle - 1);
    if (!bend.clamped_behind()) add(particle);
    sum += material::Bend(e0, e1, bend.rest).energy(bend.stiffness) / length * share;
  }
  return sum;
}

double Mechanism::paying_force(const Winched& at, std::size_t end, const double* state,
                               std::span<const Vec3> acceleration, const PointMotion& frame) const {
  const Winch& winch = *at.winch;
  const double bent = bending_force(at, state);
  if (winch.density == 0 && !at.first_drag) return bent;
  const auto point = [&](std::size_t particle) { return at.first_point + particle; };
  const auto place = [&](std::size_t i) -> Vec3 {
    return vector(state + position(point(i))) - frame.position;
  };
  const auto velocity_at = [&](std::size_t i) -> Vec3 {
    return vector(state + velocity(point(i))) - frame.velocity;
  };
  const Vec3 weight = gravity_ - frame.acceleration;
  double rate = 0, slope = 0, air = 0;  // of dL/dq' by time, dL/dq
  for (std::size_t k = 0; k < winch.rest.size(); ++k) {
    const double length = rest_of(at, k), share = winch.share(k);
    const Vec3 gap = place(k + 1) - place(k), gap_rate = velocity_at(k + 1) - velocity_at(k);
    // Of a rope that stretches: (|gap| / length)^2, and the rate of |gap|^2 / length.
    double square = 1, lengthens = share * at.longer.rate;
    if (at.first_stretch) {
      square = gap.squaredNorm() / (length * length);
      lengthens = 2 * gap.dot(gap_rate) / length - square * lengthens;
    }
    Vec3 drag = Vec3::Zero();
    if (at.first_drag) {
      const material::DragElement& link = material_.drags()[*at.first_drag + k];
      drag = material_.drag(link, state, state + velocities_);
    }
    for (const std::size_t i : {k, k + 1}) {
      const double part = flow_share(winch, end, i);
      const Winch::Flow flow = winch.flow(i, at.first, at.last);
      air += part * drag.dot(gap) / length;
      rate += part *
              ((acceleration[point(i)] - frame.acceleration).dot(gap) +
               velocity_at(i).dot(gap_rate) + lengthens * flow.speed + square * length * flow.rate);
      const double flows = flow.speed * flow.speed;
      slope +=
          share * ((velocity_at(i).squaredNorm() + (at.first_stretch ? -square : 1) * flows) / 2 +
                   weight.dot(place(i)));
    }
  }
  return winch.density / 2 * (slope - rate) + air + bent;
}

/// What an elastic link pulls with at a drum (N), by a unit of what is paid out: its tension, and
/// the energy that a unit of length carries away.
double Mechanism::paid_pull(std::size_t stretch, const double* state) const {
  const material::StretchElement& link = material_.stretches()[stretch];
  const Vec3 gap = vector(state + position(link.b)) - vector(state + position(link.a));
  const Vec3 gap_rate = vector(state + velocity(link.b)) - vector(state + velocity(link.a));
  const double length = gap.norm(), elastic = link.stiffness * (length - link.rest);
  const double along = length > 0 ? gap.dot(gap_rate) / length : 0;
  const double rate = along - length / link.rest * link.rest_rate;
  return elastic * (1 + elastic / (2 * link.stiffness * link.rest)) +
         length / link.rest * link.damping * rate;
}

double Mechanism::drum_force(std::size_t connector, std::size_t end, const double* state,
                             const double* tension, std::span<const Vec3> acceleration) const {
  Winched at = *std::ranges::find(winches_, connector, &Winched::connector);
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const double hastens = tension[rows_.size() + p];
    if (pulleys_[p].end[1].connector == connector) at.first.acceleration += hastens;
    if (pulleys_[p].end[0].connector == connector) at.last.acceleration -= hastens;
  }
  const std::size_t eye = at.first_point + (end == 0 ? 0 : at.winch->rest.size());
  double pull = 0;
  for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
    pull += at.winch->share(k) * (at.first_stretch ? paid_pull(*at.first_stretch + k, state)
                                                   : tension[at.first_row + k]);
  }
  const double own = (end == 0 ? at.first : at.last).rate;
  const double force = pull + at.winch->density / 2 * own * own +
                       paying_force(at, end, state, acceleration,
                                    {vector(state + position(eye)), vector(state + velocity(eye)),
                                     acceleration[eye]});
  if (!at.first_stretch) return force;
  // Of a unit of length a rope that stretches carries its energy away: force = T + T^2 / (2 EA).
  const std::size_t link = *at.first_stretch + (end == 0 ? 0 : at.winch->rest.size() - 1);
  const material::StretchElement& last = material_.stretches()[link];
  const double stiffness = last.stiffness * last.rest;
  return stiffness * (std::sqrt(std::max(1 + 2 * force / stiffness, 0.0)) - 1);
}

void Mechanism::add_pulleys(const World& world) {
  pulleys_.clear();
  couplings_.clear();
  soft_couplings_.clear();
  unit_.assign(world.pulleys.empty() ? 0 : points(), Vec3::Zero());
  for (const Pulley& pulley : world.pulleys) {
    Passing added{.inertia = pulley.inertia,
                  .has_friction = pulley.has_friction(),
                  .friction = pulley.friction,
                  .bearing = pulley.bearing};
    const std::uint32_t number = small(pulleys_.size());
    std::vector<std::uint32_t> bodies;
    for (const std::size_t side : {0u, 1u}) {
      const std::size_t connector = side == 0 ? pulley.from : pulley.to;
      const auto found = std::ranges::find(winches_, connector, &Winched::connector);
      RopeEnd& end = added.end[side];
      end.connector = small(connector);
      end.winched = small(static_cast<std::size_t>(found - winches_.begin()));
      const std::size_t links = found->winch->rest.size();
      added.has_mass = found->winch->density > 0;
      end.force.assign(links + 1, Vec3::Zero());
      for (std::size_t k = 0; k < links; ++k) {
        const double share = side == 0 ? -found->winch->share(k) : found->winch->share(k);
        if (found->first_stretch) {
          soft_couplings_.push_back({*found->first_stretch + small(k), number, share});
        } else {
          couplings_.push_back({found->first_row + small(k), number, share});
        }
      }
      for (std::size_t b = 0; b < body_points_.size(); ++b) {
        if (body_points_[b].point - found->first_point > links) continue;
        end.carried.push_back(small(b));
        const std::uint32_t body = body_points_[b].body;
        const auto is_it = [&](const auto& push) { return push.first == body; };
        if (std::ranges::none_of(end.pushes, is_it)) end.pushes.push_back({body, {}});
        bodies.push_back(body);
      }
    }
    std::ranges::sort(bodies);
    for (const RowEnd& end : row_ends_) {  // rows of other connectors that these bodies hold
      const std::uint32_t row = end.row, connector = rows_[row].connector;
      if (connector == pulley.from || connector == pulley.to) continue;
      if (std::ranges::binary_search(bodies, body_points_[end.body_point].body)) {
        if (couplings_.empty() || couplings_.back().row != row)
          couplings_.push_back({row, number, 0});
      }
    }
    pulleys_.push_back(std::move(added));
  }
  const auto size = static_cast<Eigen::Index>(pulleys_.size());
  passing_inertia_.setZero(size, size);
  for (Passing& pulley : pulleys_) {
    if (!pulley.has_friction) continue;
    pulley.before_inertia.setZero(size);
    pulley.inertia_of_all.setZero(size);
  }
}

/// The forces of the material that flows, and on bodies, at a pulley that turns with 1 m/s^2.
void Mechanism::find_flow(Passing& pulley, const double* state) const {
  if (!pulley.has_mass) return;
  for (const std::size_t side : {0u, 1u}) {
    RopeEnd& end = pulley.end[side];
    for (auto& [body, push] : end.pushes) push = {};
    const Winched& at = winches_[end.winched];
    const Winch& winch = *at.winch;
    const double sign = side == 0 ? -1 : 1;  // of what the connector's end pays out
    std::ranges::fill(end.force, Vec3::Zero());
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      const double* from = state + position(at.first_point + k);
      const Vec3 half = winch.density / 2 * (vector(from + 3) - vector(from));
      for (const std::size_t i : {k, k + 1}) {
        end.force[i] -= sign * flow_share(winch, 1 - side, i) * half;
      }
    }
    for (const std::uint32_t b : end.carried) {
      const BodyPoint& carried = body_points_[b];
      const std::size_t particle = carried.point - at.first_point;
      const FreeBody& body = bodies_[carried.body];
      BodyPush& push =
          std::ranges::find(end.pushes, carried.body, &std::pair<std::uint32_t, BodyPush>::first)
              ->second;
      push.linear += body.inverse_mass * end.force[particle];
      push.angular += body.world_inverse * carried.arm.cross(end.force[particle]);
    }
  }
}

template <class Visit>
void Mechanism::each_moved(const RopeEnd& end, Visit visit) const {
  const std::size_t first = winches_[end.winched].first_point;
  for (std::size_t i = 0; i < end.force.size(); ++i) {
    if (inverse_mass_[first + i] != 0) visit(first + i, inverse_mass_[first + i] * end.force[i]);
  }
}

/// Adds to unit_ what the material before or behind a pulley gives all points.
void Mechanism::give_unit(const RopeEnd& end) {
  each_moved(end, [&](std::size_t point, const Vec3& by) { unit_[point] = by; });
  for (const auto& [body, push] : end.pushes) {
    for (const BodyPoint& carried : body_points_) {
      if (body != carried.body) continue;
      unit_[carried.point] += push.linear + push.angular.cross(carried.arm);
    }
  }
}

void Mechanism::clear_unit(const Passing& pulley) {
  for (const RopeEnd& end : pulley.end) {
    each_moved(end, [&](std::size_t point, const Vec3&) { unit_[point].setZero(); });
  }
  for (const BodyPoint& carried : body_points_) unit_[carried.point].setZero();
}

void Mechanism::measure_pulleys(const double* state) {
  find_passing(state);
  for (std::size_t p = 0; p < pulleys(); ++p) {
    pulleys_[p].free_force = passing_drive(p, state, point_acceleration_);
    if (pulleys_[p].has_friction) measure_friction(p, state);
  }
  auto coupling = couplings_.begin();
  for (std::size_t p = 0; p < pulleys(); ++p) {
    Passing& pulley = pulleys_[p];
    const auto first = coupling;
    const auto each_row = [&](auto visit) {
      for (coupling = first; coupling != couplings_.end() && coupling->pulley == p; ++coupling) {
        const Row& row = rows_[coupling->row];
        visit(direction_[coupling->row].dot(unit_[row.b] - unit_[row.a]));
      }
    };
    if (pulley.has_mass) give_unit(pulley.end[0]);
    if (pulley.has_friction) {
      each_row([&](double moved) { coupling->before = moved - std::min(coupling->share, 0.0); });
    }
    if (pulley.has_mass) give_unit(pulley.end[1]);
    each_row([&](double moved) {
      coupling->value = moved - coupling->share;
      coupling->drive = -coupling->value;
    });
    const auto column = static_cast<Eigen::Index>(p);
    for (std::size_t other = 0; other < pulleys(); ++other) {
      Passing& driven = pulleys_[other];
      const double before = passing_inertia(driven, 0, pulley);
      const double behind = passing_inertia(driven, 1, pulley);
      const double all = (other == p ? pulley.inertia : 0) + before + behind;
      passing_inertia_(static_cast<Eigen::Index>(other), column) = all;
      if (!driven.has_friction) continue;
      driven.before_inertia[column] = before + (other == p ? pulley.inertia / 2 : 0);
      driven.inertia_of_all[column] = all;
    }
    if (pulley.has_mass) clear_unit(pulley);
  }
  use_friction();
}

/// How what drives `pulley` falls, by the rope before (0) or behind it (1), with the acceleration
/// of `other`, which gives unit_ to all points.
double Mechanism::passing_inertia(const Passing& pulley, std::size_t side,
                                  const Passing& other) const {
  if (!pulley.has_mass) return 0;
  double sum = 0;
  const RopeEnd& end = pulley.end[side];
  const Winched& at = winches_[end.winched];
  bool shared = false;
  for (const std::size_t side_of_other : {0u, 1u}) {
    if (other.end[side_of_other].winched != end.winched) continue;
    shared = true;
    sum += (side == side_of_other ? 1 : -1) * flow_inertia(at, 1 - side, 1 - side_of_other);
  }
  if (shared) {
    for (std::size_t i = 0; i < end.force.size(); ++i) {
      sum -= end.force[i].dot(unit_[at.first_point + i]);
    }
  } else {  // by a body alone
    for (const std::uint32_t b : end.carried) {
      const std::size_t point = body_points_[b].point;
      sum -= end.force[point - at.first_point].dot(unit_[point]);
    }
  }
  return sum;
}

/// The mass (kg) that moves with what two ends of a connector pay out, or one.
double Mechanism::flow_inertia(const Winched& at, std::size_t end, std::size_t other) const {
  double sum = 0;
  for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
    double half = at.winch->density / 2 * rest_of(at, k);
    if (at.first_stretch) half *= at.squared_stretch[k];
    for (const std::size_t i : {k, k + 1}) {
      sum += half * flow_share(*at.winch, end, i) * flow_share(*at.winch, other, i);
    }
  }
  return sum;
}

void Mechanism::find_passing(const double* state) {
  for (Winched& at : winches_) {
    for (std::size_t k = 0; k < at.squared_stretch.size(); ++k) {
      const double* from = state + position(at.first_point + k);
      at.squared_stretch[k] =
          (vector(from + 3) - vector(from)).squaredNorm() / std::pow(rest_of(at, k), 2);
    }
  }
  for (Passing& pulley : pulleys_) find_flow(pulley, state);
}

double Mechanism::passing_mass(std::size_t pulley, std::size_t other, bool before) const {
  const Passing &of = pulleys_[pulley], &by = pulleys_[other];
  double sum = pulley != other ? 0 : before ? of.inertia / 2 : of.inertia;
  if (!of.has_mass) return sum;
  for (const std::size_t side : {0u, 1u}) {
    if (before && side == 1) continue;
    for (const std::size_t others : {0u, 1u}) {
      if (by.end[others].winched != of.end[side].winched) continue;
      const double sign = side == others ? 1 : -1;
      sum += sign * flow_inertia(winches_[of.end[side].winched], 1 - side, 1 - others);
    }
  }
  return sum;
}

double Mechanism::passing_drive(std::size_t pulley, const double* state,
                                std::span<const Vec3> acceleration) const {
  const Passing& at = pulleys_[pulley];
  return paying_force(winches_[at.end[1].winched], 0, state, acceleration, {}) -
         paying_force(winches_[at.end[0].winched], 1, state, acceleration, {});
}

double Mechanism::drive_before(std::size_t pulley, const double* state,
                               std::span<const Vec3> acceleration) const {
  const Winched& from = winches_[pulleys_[pulley].end[0].winched];
  const std::size_t eye = from.first_point + from.winch->rest.size();
  const double speed = from.last.rate, turning = from.winch->density * speed * speed;
  return paying_force(
             from, 1, state, acceleration,
             {vector(state + position(eye)), vector(state + velocity(eye)), acceleration[eye]}) -
         turning / 2;
}

double Mechanism::slide_ratio(std::size_t pulley, const double* state) const {
  const Passing& at = pulleys_[pulley];
  const Winched &from = winches_[at.end[0].winched], &to = winches_[at.end[1].winched];
  const std::size_t last = from.first_point + from.winch->rest.size();
  const auto way = [&](std::size_t point) -> Vec3 {
    return (vector(state + position(point + 1)) - vector(state + position(point))).normalized();
  };
  const Vec3 arrives = way(last - 1), leaves = way(to.first_point);
  const double turn = std::atan2(arrives.cross(leaves).norm(), arrives.dot(leaves));
  const double drag = at.bearing * std::sin(turn / 2);
  return std::exp(at.friction * turn) * (1 + drag) / (1 - drag);
}

std::optional<std::size_t> Mechanism::run_through(double time, double* state) {
  constexpr double kLeast = 1e-2;
  if (pulleys() > 0) place(time, state);
  for (const Passing& pulley : pulleys_) {
    for (const RopeEnd& end : pulley.end) {
      const Winched& at = winches_[end.winched];
      for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
        if (rest_of(at, k) < kLeast * at.winch->rest[k]) return end.connector;
      }
    }
  }
  return {};
}

void Mechanism::right_side(std::vector<double>& right) const {
  right.resize(unknowns());
  for (std::size_t r = 0; r < rows_.size(); ++r) right[r] = free_acceleration(r);
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const Passing& pulley = pulleys_[p];
    right[rows_.size() + p] =
        pulley.slip == Slip::stick ? 0 : pulley.excess() * pulley.before - pulley.free_force;
  }
}

void Mechanism::push_pulleys(const double* by, double* velocities, double* speeds) const {
  for (std::size_t p = 0; p < pulleys(); ++p) {
    if (pulleys_[p].has_mass) {
      for (const RopeEnd& end : pulleys_[p].end) {
        each_moved(end, [&](std::size_t point, const Vec3& unit) {
          vector(velocities + 3 * point) += by[p] * unit;
        });
      }
    }
    speeds[p] += by[p];
  }
}

// Friction of rope that passes pulleys: how much larger one tension is than the other.

/// The rope before the pulley by itself, as seen from there, and the ratio of tensions.
void Mechanism::measure_friction(std::size_t pulley, const double* state) {
  pulleys_[pulley].before = drive_before(pulley, state, point_acceleration_);
  pulleys_[pulley].ratio = slide_ratio(pulley, state);
}

/// The pulleys' equations under friction: where rope stays, its acceleration is zero.
void Mechanism::use_friction() {
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const Passing& pulley = pulleys_[p];
    auto row = passing_inertia_.row(static_cast<Eigen::Index>(p));
    if (pulley.slip == Slip::stick) {
      row.setZero();
      row[static_cast<Eigen::Index>(p)] = 1;
    } else if (pulley.excess() != 0) {
      row += pulley.excess() * pulley.before_inertia.transpose();
    }
  }
  for (Coupling& coupling : couplings_) {
    const Passing& pulley = pulleys_[coupling.pulley];
    if (pulley.slip == Slip::stick) coupling.drive = 0;
    if (pulley.excess() != 0) coupling.drive -= pulley.excess() * coupling.before;
  }
}

Mechanism::Pull Mechanism::pull_at(std::size_t pulley, const double* tension) const {
  const Passing& at = pulleys_[pulley];
  const Eigen::Map<const Eigen::VectorXd> hastens(tension + rows_.size(),
                                                  static_cast<Eigen::Index>(pulleys()));
  Pull pull{at.before + at.before_inertia.dot(hastens), 0, at.ratio};
  double drive = at.free_force;
  for (const Coupling& coupling : couplings_) {
    if (coupling.pulley != pulley) continue;
    pull.before += coupling.before * tension[coupling.row];
    drive -= coupling.value * tension[coupling.row];
  }
  pull.behind = pull.before + drive - at.inertia_of_all.dot(hastens);
  return pull;
}

}  // namespace taut
