// Free bodies in the smooth motion among obstacles: how they respond to pulls and to what their
// capsules touch.
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kNudge = 2e-3;    // of a curve: the step of a difference
constexpr double kLongest = 1e-4;  // s, of it

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
  capsules_ = capsules_of_free_bodies(world);
  meetings_ = meetings_of_bodies(world, world.obstacles, world.pairs);
  is_carried_.assign(mechanism_.points(), false);
  for (const auto& carried : mechanism_.body_points()) is_carried_[carried.point] = true;
  double longest = 0;
  for (const BodyCapsule& capsule : capsules_) {
    if (capsule.touches()) longest = std::max(longest, (capsule.to - capsule.from).norm());
  }
  if (touching_ == 0) touching_ = kTouching * (longest > 0 ? longest : 1);
  for (auto* array : {&body_free_, &body_pulled_, &body_added_, &twists_}) {
    array->assign(capsules_.size(), Vec6::Zero());
  }
  body_mobility_.assign(capsules_.size(), Mat6::Zero());
  body_coupled_.set_apart(body_mobility_);
  body_touches_.clear();
}

Capsule ContactMotion::capsule(const State& state, std::size_t body) const {
  if (is_part(small(body))) return capsule_of_part(state, part(small(body)));
  const double* q = &state[mechanism_.pose(body)];
  const Quat rotation = quaternion(q + 3).normalized();
  const BodyCapsule& own = capsules_[body];
  const Vec3 centre = ConstMap(q);
  return {centre + rotation * own.from, centre + rotation * own.to, own.radius};
}

Vec6 ContactMotion::twist(const State& state, std::size_t body) const {
  return Eigen::Map<const Vec6>(&state[mechanism_.twist(body)]);
}

/// Where what a body may touch is.
Pose ContactMotion::solid(const BodyMeeting& meeting, const State& state) const {
  if (meeting.other == kNoBody) return frames_[meeting.obstacle].pose();
  const double* q = &state[mechanism_.pose(meeting.other)];
  return pose_of_solid(meeting, ConstMap(q), quaternion(q + 3).normalized());
}

/// Tells a touch where it is; the gap there.
SpotGap ContactMotion::aim(BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Capsule own = capsule(state, at.body);
  const Pose place = solid(meeting, state);
  if (is_part(at.body)) {
    const SpotGap near = gap_of_part(at, place, own);
    at.touch.normal = near.normal;
    at.share = near.along;
    at.arm = own.at(near.along);
    return near;
  }
  const SpotGap near = gap_at(meeting.shape, place, own, at.spot);
  const Vec3 there = own.at(near.along) - own.radius * near.normal;
  at.touch.normal = near.normal;
  at.arm = there - ConstMap(&state[mechanism_.pose(at.body)]);
  if (at.other != kNoBody) at.other_arm = there - ConstMap(&state[mechanism_.pose(at.other)]);
  return near;
}

/// The place of a touch, of a link on its line.
Vec3 ContactMotion::where(const BodyTouch& at, const State& state) const {
  if (is_part(at.body)) return at.arm;
  return ConstMap(&state[mechanism_.pose(at.body)]) + at.arm;
}

/// The velocity of a body past what it touches, there.
Vec3 ContactMotion::passing(const BodyTouch& at, const State& state) const {
  const Vec3 moves =
      is_part(at.body) ? velocity_of_part(at, state) : velocity_at(twist(state, at.body), at.arm);
  if (at.other != kNoBody) return moves - velocity_at(twist(state, at.other), at.other_arm);
  return moves - surface_velocity(frames_[meetings_[at.meeting].obstacle], where(at, state));
}

/// m/s: no point of what touches there moves faster past another.
double ContactMotion::quickness(const BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Vec6 moves = twist(state, at.body);
  const double length = (capsules_[at.body].to - capsules_[at.body].from).norm();
  const double curve = capsules_[at.body].radius + std::min(meeting.shape.sharpest(), 1.0);
  if (at.other != kNoBody) {
    const Vec6 other = twist(state, at.other);
    return moves.head<3>().norm() + other.head<3>().norm() +
           (moves.tail<3>().norm() + other.tail<3>().norm()) *
               (length + meeting.shape.length + curve);
  }
  const FrameMotion& frame = frames_[meeting.obstacle];
  return moves.head<3>().norm() + frame.velocity.norm() +
         (moves.tail<3>().norm() + frame.spin.norm()) * (length + curve);
}

/// Asks for the accelerations with which a body stays on the surface, and with which it does not
/// slide: they cancel the acceleration of its passing under the present twists and motions. The
/// touch's point travels along both.
void ContactMotion::ask_accelerations(BodyTouch& at, const State& state) const {
  if (is_part(at.body)) return ask_of_part(at, state);
  const BodyMeeting& meeting = meetings_[at.meeting];
  const double curve = capsules_[at.body].radius + std::min(meeting.shape.sharpest(), 1.0);
  const double step =
      std::min(kLongest, kNudge * std::max(curve, 1e-3) / std::max(quickness(at, state), 1e-9));
  Vec3 past = Vec3::Zero();
  double separating = 0;
  State moved = state;
  const auto move = [&](std::size_t body, double time) {
    double* q = &moved[mechanism_.pose(body)];
    const Vec6 moves = twist(state, body);
    std::copy_n(&state[mechanism_.pose(body)], 7, q);
    Map{q} += time * moves.head<3>();
    rotate(time * moves.tail<3>(), q + 3);
    return moves;
  };
  for (const auto& [times, weight] :
       {std::pair(-2.0, 1.0), std::pair(-1.0, -8.0), std::pair(1.0, 8.0), std::pair(2.0, -1.0)}) {
    const Vec6 moves = move(at.body, times * step);
    const Vec6 others = at.other != kNoBody ? move(at.other, times * step) : Vec6(Vec6::Zero());
    FrameMotion frame;
    if (at.other == kNoBody) frame = later(frames_[meeting.obstacle], times * step);
    const Pose place = at.other != kNoBody ? solid(meeting, moved) : frame.pose();
    const Capsule own = capsule(moved, at.body);
    const SpotGap near = gap_at(meeting.shape, place, own, at.spot);
    const Vec3 point = own.at(near.along) - own.radius * near.normal;
    const Vec3 surface =
        at.other != kNoBody
            ? velocity_at(others, point - ConstMap(&moved[mechanism_.pose(at.other)]))
            : surface_velocity(frame, point);
    const Vec3 passes =
        velocity_at(moves, point - ConstMap(&moved[mechanism_.pose(at.body)])) - surface;
    past += weight / (12 * step) * passes;
    separating += weight / (12 * step) * near.normal.dot(passes);
  }
  at.touch.surface = -past;
  at.touch.least = -separating;
}

/// Accelerations (or velocities) of bodies without links and touches.
void ContactMotion::free_bodies(const State* velocities) {
  for (std::size_t b = 0; b < body_free_.size(); ++b) {
    body_free_[b] << mechanism_.gravity(), mechanism_.bodies()[b].gyration;
    if (velocities) body_free_[b] = twist(*velocities, b);
  }
}

/// How bodies respond without what they touch.
void ContactMotion::free_mobilities() {
  for (std::size_t b = 0; b < body_mobility_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    body_mobility_[b] = contact::mobility(body.inverse_mass, body.world_inverse);
  }
  body_coupled_.set_apart(body_mobility_);
}

/// Adds what touches give to the bodies that the system has.
void ContactMotion::add_twists(std::span<const BodyTouch> touches, std::span<Vec6> twists) const {
  for (std::size_t i = 0; i < body_system_.bodies().size(); ++i) {
    twists[body_system_.bodies()[i]] += body_system_.twist(touches, i);
  }
}

/// The response of bodies, and of the points that they carry, to `tension`: in the touches' present
/// states (`held`) or in those that the laws ask for.
void ContactMotion::couple_bodies(std::span<const double> tension, std::span<const Vec3> along,
                                  bool held) {
  if (body_free_.empty()) return;
  std::ranges::fill(body_pulled_, Vec6::Zero());
  free_mobilities();
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const Vec3 pull = end.sign * tension[end.row] * along[end.row];
    Vec6 wrench;
    wrench << pull, carried.arm.cross(pull);
    body_pulled_[carried.body] += body_mobility_[carried.body] * wrench;
  }
  body_added_ = body_pulled_;
  for (std::size_t b = 0; b < twists_.size(); ++b) twists_[b] = body_free_[b] + body_pulled_[b];
  clusters_.each(body_touches_, [&](std::size_t first, std::size_t count) {
    const std::span touches(&body_touches_[first], count);
    std::vector<Vec3> bare;
    for (const BodyTouch& at : touches) bare.push_back(contact::passing(twists_, at));
    body_system_.assemble(body_mobility_, touches);
    if (held) {
      body_system_.hold(bare, touches);
    } else if (!body_system_.solve(bare, touches, 0)) {
      throw Unresolved{0, "contact and friction of a body have no solution"};
    }
    add_twists(touches, body_added_);
    body_system_.couple(touches, body_coupled_);
  });
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
    at.ahead = at.touch.sliding;  // the way in which it began
    if (across.norm() > still(at)) at.ahead = heading(across, at.touch.sliding);
  }
}

/// Takes bodies back to surfaces and from velocities that leave them; returns the largest gap (m).
double ContactMotion::project_bodies(State& state) {
  double worst = 0;
  free_mobilities();
  clusters_.each(body_touches_, [&](std::size_t first, std::size_t count) {
    std::vector<BodyTouch> touches(&body_touches_[first], &body_touches_[first] + count);
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
    body_system_.assemble(body_mobility_, normals);
    body_system_.hold(apart, normals);
    std::ranges::fill(twists_, Vec6::Zero());
    add_twists(normals, twists_);
    body_system_.assemble(body_mobility_, touches);
    body_system_.hold(bare, touches);
    body_system_.couple(touches, body_coupled_);
    for (std::size_t i = 0; i < body_system_.bodies().size(); ++i) {
      const std::uint32_t b = body_system_.bodies()[i];
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += body_system_.twist(touches, i);
      double* q = &state[mechanism_.pose(b)];
      Map{q} += twists_[b].head<3>();
      rotate(twists_[b].tail<3>(), q + 3);
    }
  });
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
    for (const std::uint32_t moved : body_coupled_.moved_with(carried.body)) {
      body_pulled_[moved] += body_coupled_.between(moved, carried.body) * wrench;
    }
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

}  // namespace taut::contact
