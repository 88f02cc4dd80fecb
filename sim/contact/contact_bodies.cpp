// Free bodies in the smooth motion among obstacles: how they answer to pulls and to what their
// capsules touch.
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kSpare = 1e-9;     // of forces per mass: no event yet
constexpr double kArrives = 1e-10;  // m/s
constexpr double kFlat = 1e-12;     // rad/s: out of a plane by rounding
constexpr double kFar = 1;          // an event that is none
constexpr double kSame = 1e-6;      // of an axis: a spot so near to an end is that
constexpr double kNudge = 2e-3;     // of a curve: the step of a difference
constexpr double kLongest = 1e-4;   // s, of it

/// A frame after so many seconds.
FrameMotion later(const FrameMotion& frame, double time) {
  FrameMotion moved = frame;
  moved.position += time * (frame.velocity + time / 2 * frame.acceleration);
  moved.velocity += time * frame.acceleration;
  moved.spin += time * frame.spin_rate;
  const Vec3 turn = time * (frame.spin + time / 2 * frame.spin_rate);
  const double size = turn.norm();
  if (size > 0) moved.rotation = Quat(Eigen::AngleAxisd(size, turn / size)) * frame.rotation;
  return moved;
}

Vec3 surface_velocity(const FrameMotion& frame, const Vec3& at) {
  return frame.velocity + frame.spin.cross(at - frame.position);
}

}  // namespace

void ContactMotion::rebuild_bodies(const World& world) {
  capsules_.clear();
  is_carried_.assign(mechanism_.points(), false);
  for (const auto& carried : mechanism_.body_points()) is_carried_[carried.point] = true;
  double reach = 0;
  for (const Body& body : world.bodies) {
    if (body.driven()) continue;
    BodyCapsule capsule = body.capsule;
    capsule.from -= body.mass_properties.centre;
    capsule.to -= body.mass_properties.centre;
    if (capsule.touches()) reach = std::max(reach, (capsule.to - capsule.from).norm());
    capsules_.push_back(capsule);
  }
  if (touching_ == 0) touching_ = kTouching * (reach > 0 ? reach : 1);
  for (auto* array : {&body_free_, &body_pulled_, &body_added_}) {
    array->assign(capsules_.size(), Vec6::Zero());
  }
  body_answer_.assign(capsules_.size(), Mat6::Zero());
  body_touches_.clear();
}

Capsule ContactMotion::capsule(const State& state, std::size_t body) const {
  const double* q = &state[mechanism_.pose(body)];
  const Quat rotation = quaternion(q + 3).normalized();
  const BodyCapsule& own = capsules_[body];
  const Vec3 centre = ConstMap(q);
  return {centre + rotation * own.from, centre + rotation * own.to, own.radius};
}

Vec6 ContactMotion::twist(const State& state, std::size_t body) const {
  return Eigen::Map<const Vec6>(&state[mechanism_.twist(body)]);
}

/// Tells a touch where it is; the gap there.
SpotGap ContactMotion::aim(BodyTouch& at, const State& state) const {
  const Capsule own = capsule(state, at.body);
  const SpotGap near =
      gap_at(obstacles_[at.obstacle].shape, frames_[at.obstacle].pose(), own, at.spot);
  at.touch.normal = near.normal;
  at.arm =
      own.at(near.along) - own.radius * near.normal - ConstMap(&state[mechanism_.pose(at.body)]);
  return near;
}

/// The velocity of a body past the surface where it touches.
Vec3 ContactMotion::passing(const BodyTouch& at, const State& state) const {
  const Vec3 there = ConstMap(&state[mechanism_.pose(at.body)]) + at.arm;
  return velocity_at(twist(state, at.body), at.arm) - surface_velocity(frames_[at.obstacle], there);
}

/// Asks for the accelerations with which a body stays on the surface, and with which it does not
/// slide: what twists and motions as they are make of its passing is taken back. The touch's point
/// travels along both.
void ContactMotion::ask_accelerations(BodyTouch& at, const State& state) const {
  const FrameMotion& frame = frames_[at.obstacle];
  const Shape& shape = obstacles_[at.obstacle].shape;
  const Vec6 moves = twist(state, at.body);
  const double length = (capsules_[at.body].to - capsules_[at.body].from).norm();
  const double curve = capsules_[at.body].radius + std::min(shape.sharpest(), 1.0);
  const double speed = moves.head<3>().norm() + frame.velocity.norm() +
                       (moves.tail<3>().norm() + frame.spin.norm()) * (length + curve);
  const double step = std::min(kLongest, kNudge * std::max(curve, 1e-3) / std::max(speed, 1e-9));
  Vec3 normal, past = Vec3::Zero();
  double parts = 0;
  State moved = state;
  double* q = &moved[mechanism_.pose(at.body)];
  for (const auto& [times, weight] :
       {std::pair(-2.0, 1.0), std::pair(-1.0, -8.0), std::pair(1.0, 8.0), std::pair(2.0, -1.0)}) {
    std::copy_n(&state[mechanism_.pose(at.body)], 7, q);
    Map{q} += times * step * moves.head<3>();
    rotate(times * step * moves.tail<3>(), q + 3);
    const FrameMotion there = later(frame, times * step);
    const Capsule own = capsule(moved, at.body);
    const SpotGap near = gap_at(shape, there.pose(), own, at.spot);
    const Vec3 point = own.at(near.along) - own.radius * near.normal;
    const Vec3 passes = velocity_at(moves, point - ConstMap(q)) - surface_velocity(there, point);
    past += weight / (12 * step) * passes;
    parts += weight / (12 * step) * near.normal.dot(passes);
  }
  at.touch.surface = -past;
  at.touch.least = -parts;
}

/// Accelerations (or velocities) of bodies without links and touches.
void ContactMotion::free_bodies(const State* velocities) {
  for (std::size_t b = 0; b < body_free_.size(); ++b) {
    body_free_[b] << mechanism_.gravity(), mechanism_.bodies()[b].gyration;
    if (velocities) body_free_[b] = twist(*velocities, b);
  }
}

/// What bodies do under `tension`, in the states that their touches have or in those that the laws
/// ask for; and with them the points that they carry.
void ContactMotion::answer_bodies(std::span<const double> tension, std::span<const Vec3> along,
                                  bool held) {
  if (body_free_.empty()) return;
  std::ranges::fill(body_pulled_, Vec6::Zero());
  for (std::size_t b = 0; b < body_answer_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    body_answer_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
  }
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const Vec3 pull = end.sign * tension[end.row] * along[end.row];
    Vec6 wrench;
    wrench << pull, carried.arm.cross(pull);
    body_pulled_[carried.body] += body_answer_[carried.body] * wrench;
  }
  body_added_ = body_pulled_;
  for (std::size_t first = 0, end = 0; first < body_touches_.size(); first = end) {
    const std::size_t b = body_touches_[first].body;
    while (end < body_touches_.size() && body_touches_[end].body == b) ++end;
    const std::span touches(&body_touches_[first], end - first);
    std::vector<Vec3> bare;
    for (const BodyTouch& at : touches) {
      bare.push_back(velocity_at(body_free_[b] + body_pulled_[b], at.arm));
    }
    body_system_.assemble(body_answer_[b], touches);
    if (held) {
      body_system_.hold(bare, touches);
    } else if (!body_system_.solve(bare, touches, 0)) {
      throw Unresolved{0, "contact and friction of a body have no solution"};
    }
    body_added_[b] += body_system_.twist(touches);
    body_answer_[b] = body_system_.answer(touches);
  }
  for (const auto& carried : mechanism_.body_points()) {
    added_[carried.point] = velocity_at(body_added_[carried.body], carried.arm);
  }
}

/// Aims the closed touches of bodies and the accelerations that they ask for.
void ContactMotion::aim_bodies(const State& state) {
  for (BodyTouch& at : body_touches_) {
    aim(at, state);
    ask_accelerations(at, state);
    const Vec3 slip = passing(at, state);
    const Vec3 across = slip - at.touch.normal.dot(slip) * at.touch.normal;
    if (at.touch.state != Touch::State::slides) continue;
    at.ahead = at.touch.slid;  // the way in which it began
    if (across.norm() > kStill) at.ahead = heading(across, at.touch.slid);
  }
}

/// Takes bodies back to surfaces and from velocities that leave them; returns the largest gap (m).
double ContactMotion::project_bodies(State& state) {
  double worst = 0;
  for (std::size_t b = 0; b < body_answer_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    body_answer_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
  }
  for (std::size_t first = 0, end = 0; first < body_touches_.size(); first = end) {
    const std::size_t b = body_touches_[first].body;
    while (end < body_touches_.size() && body_touches_[end].body == b) ++end;
    std::vector<BodyTouch> touches(&body_touches_[first], &body_touches_[first] + (end - first));
    std::vector<BodyTouch> normals = touches;
    std::vector<Vec3> apart, bare;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      BodyTouch& at = touches[i];
      const SpotGap near = aim(at, state);
      worst = std::max(worst, std::abs(near.distance));
      apart.push_back(near.distance * near.normal);
      bare.push_back(passing(at, state));
      at.touch.least = at.touch.slide = 0;
      at.touch.surface.setZero();
      normals[i] = at;
      normals[i].touch.state = Touch::State::slides;
    }
    const Mat6 free = body_answer_[b];
    body_system_.assemble(free, normals);
    body_system_.hold(apart, normals);
    const Vec6 shift = body_system_.twist(normals);
    body_system_.assemble(free, touches);
    body_system_.hold(bare, touches);
    Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += body_system_.twist(touches);
    body_answer_[b] = body_system_.answer(touches);
    double* q = &state[mechanism_.pose(b)];
    Map{q} += shift.head<3>();
    rotate(shift.tail<3>(), q + 3);
  }
  return worst;
}

/// Moves bodies as rows' impulses `change_` change their velocities, or poses by as much.
void ContactMotion::shift_bodies(std::span<const Vec3> along, bool poses, State& state) {
  std::ranges::fill(body_pulled_, Vec6::Zero());
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const Vec3 pull = end.sign * change_[end.row] * along[end.row];
    Vec6 wrench;
    wrench << pull, carried.arm.cross(pull);
    body_pulled_[carried.body] += body_answer_[carried.body] * wrench;
  }
  for (std::size_t b = 0; b < body_pulled_.size(); ++b) {
    if (poses) {
      double* q = &state[mechanism_.pose(b)];
      Map{q} += body_pulled_[b].head<3>();
      rotate(body_pulled_[b].tail<3>(), q + 3);
    } else {
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += body_pulled_[b];
    }
  }
}

void ContactMotion::body_events(const State& state, std::vector<double>& values) const {
  for (std::uint32_t b = 0; b < capsules_.size(); ++b) {
    if (!capsules_[b].touches()) continue;
    const Capsule own = capsule(state, b);
    for (std::uint32_t o = 0; o < obstacles_.size(); ++o) {
      if (!obstacles_[o].touches(capsules_[b].category)) continue;
      const auto gaps = all_gaps(obstacles_[o].shape, frames_[o].pose(), own);
      for (const Spot spot : kSpots) {
        const auto is_here = [&](const BodyTouch& at) {
          return at.body == b && at.obstacle == o && at.spot == spot;
        };
        if (std::ranges::any_of(body_touches_, is_here)) continue;
        const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
        BodyTouch there{.body = b, .obstacle = o, .spot = spot, .touch = {}};
        double value = near.distinct ? near.distance + touching_ / 2 : kFar;
        if (value < 0) {
          aim(there, state);
          value = crossing(value, near.normal.dot(passing(there, state)) >= -kStill);
        }
        values.push_back(value);
      }
    }
  }
  for (const BodyTouch& at : body_touches_) {
    const double ease = mechanism_.bodies()[at.body].inverse_mass;
    const double push = ease * at.touch.push;
    const double spare = kSpare * (body_free_[at.body].head<3>().norm() +
                                   body_pulled_[at.body].head<3>().norm() + std::abs(push));
    values.push_back(push + spare);
    if (at.spot != Spot::from && at.spot != Spot::to) {
      const double along = gap_at(obstacles_[at.obstacle].shape, frames_[at.obstacle].pose(),
                                  capsule(state, at.body), at.spot)
                               .along;
      values.push_back(std::min(along, 1 - along) - kSame);
    }
    if (at.touch.stick == 0) continue;
    if (at.touch.state == Touch::State::sticks) {
      values.push_back(at.touch.stick * push - ease * at.touch.rub.norm() + spare);
    } else {
      values.push_back(passing(at, state).dot(at.touch.slid) + kStill / 2);
    }
  }
}

/// Adds their places, and the ways in which they and what they touch go.
void ContactMotion::add_ways_of_bodies(const State& state, std::vector<Vec3>& places,
                                       std::vector<Vec3>& ways) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    places.push_back(ConstMap(&state[mechanism_.pose(b)]));
    ways.push_back(twist(state, b).head<3>());
    if (!capsules_[b].touches()) continue;
    const Capsule own = capsule(state, b);
    places.push_back(own.from);
    places.push_back(own.to);
  }
  for (const BodyTouch& at : body_touches_) {
    const Vec3 there = ConstMap(&state[mechanism_.pose(at.body)]) + at.arm;
    places.push_back(there);
    ways.push_back(at.touch.normal);
    ways.push_back(surface_velocity(frames_[at.obstacle], there));
  }
}

/// Whether bodies turn about a direction alone, and go on to.
bool ContactMotion::turn_within(const State& state, const Vec3& normal) const {
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    const Vec3 spin = twist(state, b).tail<3>();
    const Vec3 eased = mechanism_.bodies()[b].world_inverse * normal;
    if (normal.cross(spin).norm() > kFlat) return false;
    if (normal.cross(eased).norm() > kFlat * eased.norm()) return false;
  }
  return true;
}

/// All that bodies touch and do not leave.
void ContactMotion::find_body_touches(const State& state) {
  body_touches_.clear();
  for (std::uint32_t b = 0; b < capsules_.size(); ++b) {
    if (!capsules_[b].touches()) continue;
    const Capsule own = capsule(state, b);
    for (std::uint32_t o = 0; o < obstacles_.size(); ++o) {
      if (!obstacles_[o].touches(capsules_[b].category)) continue;
      const auto gaps = all_gaps(obstacles_[o].shape, frames_[o].pose(), own);
      for (const Spot spot : kSpots) {
        const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
        if (!near.distinct || near.distance > touching_) continue;
        BodyTouch found{.body = b, .obstacle = o, .spot = spot, .touch = {}};
        aim(found, state);
        found.touch.stick = obstacles_[o].static_friction;
        found.touch.slide = obstacles_[o].kinetic_friction;
        const Vec3 slip = passing(found, state);
        const double parts = near.normal.dot(slip);
        if (parts > kArrives) continue;  // it leaves
        found.touch.slid = slip - parts * near.normal;
        body_touches_.push_back(found);
      }
    }
  }
}

/// Asks for velocities after an impact; whether a body arrives.
bool ContactMotion::bodies_arrive(const State& state) {
  free_bodies(&state);
  bool any = false;
  for (BodyTouch& at : body_touches_) {
    const Vec3 there = ConstMap(&state[mechanism_.pose(at.body)]) + at.arm;
    at.ahead.setZero();
    at.given.setZero();
    at.touch.surface = surface_velocity(frames_[at.obstacle], there);
    const double carried = at.touch.normal.dot(at.touch.surface);
    const double into = carried - at.touch.normal.dot(velocity_at(body_free_[at.body], at.arm));
    any = any || into > kArrives;
    const double bounce = obstacles_[at.obstacle].restitution * into;
    at.touch.least = carried + (bounce > slowest_ ? bounce : 0);
  }
  return any;
}

/// Asks for accelerations, before the active set is chosen.
void ContactMotion::ask_of_bodies(const State& state) {
  free_bodies(nullptr);
  for (BodyTouch& at : body_touches_) {
    aim(at, state);
    ask_accelerations(at, state);
    at.given.setZero();
    at.ahead.setZero();
    if (at.touch.slid.norm() > kStill) at.ahead = heading(at.touch.slid, at.touch.slid);
    at.touch.slid.setZero();
  }
}

/// Takes the active set that was chosen.
void ContactMotion::take_touches() {
  std::erase_if(body_touches_,
                [](const BodyTouch& at) { return at.touch.state == Touch::State::open; });
  for (BodyTouch& at : body_touches_) {
    if (at.touch.stick == 0) at.touch.state = Touch::State::slides;
    if (at.touch.state == Touch::State::sticks) continue;
    if (at.ahead.isZero(0)) {
      const Vec3 slip =
          velocity_at(body_free_[at.body] + body_added_[at.body], at.arm) - at.touch.surface;
      const Vec3 across = slip - at.touch.normal.dot(slip) * at.touch.normal;
      if (across.squaredNorm() > 0) at.ahead = heading(across, across);
    }
    at.touch.slid = at.ahead;
  }
}

}  // namespace taut::contact
