#include "sim/contact/body_contacts.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "sim/links/linear_systems.h"
#include "sim/motion/rotation.h"
#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr int kMostSweeps = 50;
constexpr double kSettled = 1e-8;  // of what is given: a sweep that changes less is the last

void give(std::span<const Mat6> mobility, const BodyTouch& at, const Vec3& impulse,
          std::span<Vec6> twists) {
  twists[at.body] += mobility[at.body] * wrench(impulse, at.arm);
  if (at.other == kNoBody) return;
  twists[at.other] -= mobility[at.other] * wrench(impulse, at.other_arm);
}

/// The friction of a touch that has `before` and slips: what stops it, or else the cone's point
/// next to a step against the slip, so that it ends where both point opposite ways.
Vec3 friction_after(const Touch& touch, const EffectiveMass& mass, const Vec3& before,
                    const Vec3& slip, double push) {
  const double most = (touch.state == Touch::State::slides ? touch.slide : touch.stick) * push;
  const Vec3 stopping = before - mass.across * slip;
  if (stopping.norm() <= most) return stopping;
  const Vec3 against = before - mass.least_across * slip;
  return std::min(1.0, most / against.norm()) * against;
}

/// Goes through the touches until they change little.
void sweep(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (int i = 0; i < kMostSweeps; ++i) {
    check_stop();
    double most = 0, changed = 0;
    for (std::size_t t = 0; t < touches.size(); ++t) {
      BodyTouch& at = touches[t];
      const Vec3 &normal = at.touch.normal, before = at.given;
      const double pushed = normal.dot(before);
      const Vec3 rubbed = before - pushed * normal;
      const double missing = at.touch.least - normal.dot(passing(twists, at));
      const double push = std::max(0.0, pushed + masses[t].along * missing);
      give(mobility, at, (push - pushed) * normal, twists);

      const Vec3 slip = across(normal) * (passing(twists, at) - at.touch.surface);
      const Vec3 friction = friction_after(at.touch, masses[t], rubbed, slip, push);
      give(mobility, at, friction - rubbed, twists);
      at.given = push * normal + friction;
      most = std::max(most, at.given.norm());
      changed = std::max(changed, (at.given - before).norm());
    }
    if (changed <= kSettled * most) return;
  }
}

/// Whether a touch takes all that static friction gives.
bool slips(const BodyTouch& at) {
  const double push = at.touch.normal.dot(at.given);
  return (across(at.touch.normal) * at.given).norm() >= (1 - kSettled) * at.touch.stick * push;
}

}  // namespace

EffectiveMass effective_mass(std::span<const Mat6> mobilities, const BodyTouch& at) {
  Mat3 response = mobility(mobilities[at.body], at.arm, at.arm);  // 1/kg
  if (at.other != kNoBody) response += mobility(mobilities[at.other], at.other_arm, at.other_arm);
  const Vec3& normal = at.touch.normal;
  const Mat3 plane = across(normal), slip = plane * response * plane;
  const double along = normal.dot(response * normal);
  const Mat3 whole = slip + along * normal * normal.transpose();
  return {1 / along, plane * whole.inverse() * plane, 1 / slip.norm()};
}

void relax(std::span<const Mat6> mobility, std::span<const EffectiveMass> masses,
           std::span<BodyTouch> touches, std::span<Vec6> twists) {
  for (BodyTouch& at : touches) at.touch.state = Touch::State::sticks;
  sweep(mobility, masses, touches, twists);
  bool slide = false;
  for (BodyTouch& at : touches) {
    if (at.touch.slide == at.touch.stick || !slips(at)) continue;
    at.touch.state = Touch::State::slides;
    slide = true;
  }
  if (slide) sweep(mobility, masses, touches, twists);
}

namespace {

constexpr double kUnchanged = 1e-6;  // of the greatest twist: a change as good as none

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

Capsule placed(const BodyCapsule& capsule, const Pose& at) {
  return {at.to_world(capsule.from), at.to_world(capsule.to), capsule.radius};
}

/// m/s, what gravity alone may make in a step.
double resting_speed(const Mechanism& mechanism, double dt) {
  return 2 * dt * mechanism.gravity().norm();
}

/// Whether a capsule is farther than `near` (m) from a solid, as its middle tells: distances change
/// no faster than places.
bool is_far(const Shape& shape, const Pose& frame, const Capsule& capsule, double near) {
  const Vec3 middle = frame.rotation.conjugate() * (capsule.at(0.5) - frame.position);
  const double reach = (capsule.to - capsule.from).norm() / 2 + capsule.radius;
  return shape.from(middle).distance > reach + near;
}

}  // namespace

Pose BodyContacts::pose_of(const Mechanism& mechanism, std::uint32_t one,
                           const std::vector<double>& state) const {
  if (one >= bodies()) {
    return {ConstMap(&state[mechanism.position(beads_[one - bodies()])]), Quat::Identity()};
  }
  const double* q = &state[mechanism.pose(one)];
  return {ConstMap(q), quaternion(q + 3)};
}

Vec6 BodyContacts::twist_of(const Mechanism& mechanism, std::uint32_t one,
                            const std::vector<double>& state) const {
  if (one < bodies()) return Eigen::Map<const Vec6>(&state[mechanism.twist(one)]);
  Vec6 twist = Vec6::Zero();
  twist.head<3>() = ConstMap(&state[mechanism.velocity(beads_[one - bodies()])]);
  return twist;
}

void BodyContacts::set_twist(const Mechanism& mechanism, std::uint32_t one, const Vec6& twist,
                             std::vector<double>& state) const {
  if (one < bodies()) {
    Eigen::Map<Vec6>(state.data() + mechanism.twist(one)) = twist;
  } else {
    Map(state.data() + mechanism.velocity(beads_[one - bodies()])) = twist.head<3>();
  }
}

Mat6 BodyContacts::mobility_of(const Mechanism& mechanism, std::uint32_t one,
                               const std::vector<double>& state) const {
  if (one >= bodies()) {
    return mobility(mechanism.inverse_mass()[beads_[one - bodies()]], Mat3::Zero());
  }
  const auto& body = mechanism.bodies()[one];
  const Mat3 turn = pose_of(mechanism, one, state).rotation.toRotationMatrix();
  return mobility(body.inverse_mass, turn * body.inverse_inertia * turn.transpose());
}

/// How far a point of one has moved since `before` (m).
Vec3 BodyContacts::moved(const Mechanism& mechanism, std::uint32_t one, const Vec3& arm,
                         const std::vector<double>& before,
                         const std::vector<double>& state) const {
  const Pose now = pose_of(mechanism, one, state), old = pose_of(mechanism, one, before);
  return now.position + arm - old.to_world(now.rotation.conjugate() * arm);
}

void BodyContacts::rebuild(const Mechanism& mechanism, const World& world) {
  meetings_.clear();
  beads_.clear();
  groups_.clear();
  points_.clear();
  numbers_.clear();
  if (!has_touching_bodies(world) && world.bead_pairs.empty()) return;
  obstacles_ = world.obstacles;
  capsules_ = capsules_of_free_bodies(world);
  meetings_ = meetings_of_bodies(world, obstacles_, world.pairs);
  frames_.reserve(obstacles_.size());
  std::size_t spots = kSpots.size() * meetings_.size();
  const std::vector<BodyMeeting> of_beads = meetings_of_beads(world, mechanism, world.bead_pairs);
  spots += of_beads.size();
  add_beads(world, of_beads);
  touches_.reserve(spots);
  masses_.reserve(spots);
  here_.assign(capsules_.size(), kNoBody);
  numbers_.reserve(capsules_.size());
  mobility_.reserve(capsules_.size());
  twists_.reserve(capsules_.size());
}

/// Numbers beads behind the bodies.
void BodyContacts::add_beads(const World& world, std::span<const BodyMeeting> meetings) {
  std::vector<double> radius;
  for (const Connector& connector : world.connectors) {
    radius.insert(radius.end(), connector.particles(), connector.radius);
  }
  std::vector<std::uint32_t> number(radius.size(), kNoBody);
  for (const BodyMeeting& meeting : meetings) {
    std::uint32_t& one = number[meeting.body];
    if (one == kNoBody) {
      one = small(capsules_.size());
      capsules_.push_back({.radius = radius[meeting.body]});
      beads_.push_back(meeting.body);
    }
    if (groups_.empty() || meetings_[groups_.back().first].other != meeting.other) {
      groups_.push_back({.first = meetings_.size()});
    }
    const BodyCapsule& solid = capsules_[meeting.other];
    const double reach = (solid.to - solid.from).norm() / 2 + solid.radius + radius[meeting.body];
    groups_.back().reach = std::max(groups_.back().reach, reach);
    points_.push_back(meeting.body);
    meetings_.push_back(meeting);
    meetings_.back().body = one;
    groups_.back().end = meetings_.size();
  }
}

void BodyContacts::find(const Mechanism& mechanism, double time, double dt,
                        const std::vector<double>& state) {
  // In a pile all fall alike, and what moves the lowest out moves it into the next.
  const double near = dt * resting_speed(mechanism, dt);
  frames_.clear();
  for (const Obstacle& obstacle : obstacles_) frames_.push_back(obstacle.frame(time));
  touches_.clear();
  for (const std::uint32_t one : numbers_) here_[one] = kNoBody;
  numbers_.clear();
  const std::size_t of_bodies = meetings_.size() - points_.size();
  for (std::size_t m = 0; m < of_bodies; ++m) find_at(mechanism, m, near, state);
  for (const BeadGroup& group : groups_) {
    const Vec3 middle = solid_of(mechanism, meetings_[group.first], state).position;
    const double reach = group.reach + near;
    for (std::size_t m = group.first; m < group.end; ++m) {
      const ConstMap bead(&state[mechanism.position(points_[m - of_bodies])]);
      if ((bead - middle).squaredNorm() <= reach * reach) find_at(mechanism, m, near, state);
    }
  }
  find_masses(mechanism, state);
}

/// The frame of what a meeting is with.
Pose BodyContacts::solid_of(const Mechanism& mechanism, const BodyMeeting& meeting,
                            const std::vector<double>& state) const {
  if (meeting.other == kNoBody) return frames_[meeting.obstacle].pose();
  const Pose other = pose_of(mechanism, meeting.other, state);
  return pose_of_solid(meeting, other.position, other.rotation);
}

void BodyContacts::find_at(const Mechanism& mechanism, std::size_t index, double near,
                           const std::vector<double>& state) {
  const BodyMeeting& meeting = meetings_[index];
  const Capsule capsule = placed(capsules_[meeting.body], pose_of(mechanism, meeting.body, state));
  const Pose solid = solid_of(mechanism, meeting, state);
  if (is_far(meeting.shape, solid, capsule, near)) return;
  const auto gaps = all_gaps(meeting.shape, solid, capsule);
  const auto touches = [&](const SpotGap& gap) { return gap.distance <= near; };
  if (std::ranges::none_of(gaps, touches)) return;
  // What moves one spot out may move another in: all of them count.
  for (const Spot spot : kSpots) {
    const SpotGap& gap = gaps[static_cast<std::size_t>(spot)];
    if (gap.distinct) add(mechanism, index, capsule, spot, gap, state);
  }
}

std::uint32_t BodyContacts::number_here(std::uint32_t one) {
  if (here_[one] == kNoBody) {
    here_[one] = small(numbers_.size());
    numbers_.push_back(one);
  }
  return here_[one];
}

void BodyContacts::add(const Mechanism& mechanism, std::size_t index, const Capsule& capsule,
                       Spot spot, const SpotGap& gap, const std::vector<double>& state) {
  const BodyMeeting& meeting = meetings_[index];
  const Vec3 point = capsule.at(gap.along) - capsule.radius * gap.normal;
  const Vec3 origin = meeting.other == kNoBody ? frames_[meeting.obstacle].position
                                               : pose_of(mechanism, meeting.other, state).position;
  BodyTouch& at = touches_.emplace_back();
  at.body = number_here(meeting.body);
  if (meeting.other != kNoBody) at.other = number_here(meeting.other);
  at.meeting = small(index);
  at.spot = spot;
  at.arm = point - pose_of(mechanism, meeting.body, state).position;
  at.other_arm = point - origin;
  at.touch.normal = gap.normal;
  at.touch.least = -gap.distance;
}

void BodyContacts::find_masses(const Mechanism& mechanism, const std::vector<double>& state) {
  masses_.clear();
  if (touches_.empty()) return;
  mobility_.clear();
  for (const std::uint32_t one : numbers_) {
    mobility_.push_back(mobility_of(mechanism, one, state));
  }
  for (const BodyTouch& at : touches_) masses_.push_back(effective_mass(mobility_, at));
}

Vec3 BodyContacts::surface_velocity(const BodyTouch& at) const {
  if (at.other != kNoBody) return Vec3::Zero();
  const FrameMotion& frame = frames_[meetings_[at.meeting].obstacle];
  return frame.velocity + frame.spin.cross(at.other_arm);
}

void BodyContacts::use_friction(bool used) {
  for (BodyTouch& at : touches_) {
    const BodyMeeting& meeting = meetings_[at.meeting];
    at.touch.stick = used ? meeting.static_friction : 0;
    at.touch.slide = used ? meeting.kinetic_friction : 0;
  }
}

/// Moves bodies and what they carry, and forgets the touches that stay open.
void BodyContacts::shift(const Mechanism& mechanism, std::vector<double>& state) {
  twists_.assign(numbers_.size(), Vec6::Zero());
  relax(mobility_, masses_, touches_, twists_);
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    if (twists_[i].isZero(0)) continue;
    const std::uint32_t one = numbers_[i];
    if (one >= bodies()) {
      Map(&state[mechanism.position(beads_[one - bodies()])]) += twists_[i].head<3>();
      continue;
    }
    double* q = &state[mechanism.pose(one)];
    Map(q) += twists_[i].head<3>();
    rotate(twists_[i].tail<3>(), q + 3);
  }
  for (const auto& carried : mechanism.body_points()) {
    const std::uint32_t here = here_[carried.body];
    if (here == kNoBody || twists_[here].isZero(0)) continue;
    Map place(&state[mechanism.position(carried.point)]);
    place = pose_of(mechanism, carried.body, state).to_world(carried.local);
  }
  std::size_t closed = 0;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const BodyTouch& at = touches_[i];
    const bool open =
        at.given.isZero(0) && at.touch.normal.dot(passing(twists_, at)) > at.touch.least;
    if (open) continue;
    touches_[closed] = at;
    masses_[closed++] = masses_[i];
  }
  touches_.resize(closed);
  masses_.resize(closed);
}

void BodyContacts::move_out(const Mechanism& mechanism, double time, double dt,
                            const std::vector<double>& before, std::vector<double>& state) {
  find(mechanism, time, dt, state);
  if (touches_.empty()) return;
  for (BodyTouch& at : touches_) {
    at.touch.surface =
        dt * surface_velocity(at) - moved(mechanism, numbers_[at.body], at.arm, before, state);
    if (at.other == kNoBody) continue;
    at.touch.surface += moved(mechanism, numbers_[at.other], at.other_arm, before, state);
  }
  use_friction(true);
  shift(mechanism, state);
}

/// The velocities with which touches are to end, as they came with those of `came`. True where
/// some came faster than gravity makes them.
bool BodyContacts::find_rebounds(const Mechanism& mechanism, double dt,
                                 const std::vector<double>& came) {
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    twists_[i] = twist_of(mechanism, numbers_[i], came);
  }
  const double resting = resting_speed(mechanism, dt);
  bool struck = false;
  for (BodyTouch& at : touches_) {
    Touch& touch = at.touch;
    touch.surface = surface_velocity(at);
    const double into = touch.normal.dot(touch.surface - passing(twists_, at));
    const double back = into > resting ? meetings_[at.meeting].restitution * into : 0;
    touch.least = touch.normal.dot(touch.surface) + back;
    struck = struck || into > resting;
  }
  return struck;
}

bool BodyContacts::push(const Mechanism& mechanism, std::vector<double>& state) {
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    twists_[i] = twist_of(mechanism, numbers_[i], state);
  }
  relax(mobility_, masses_, touches_, twists_);
  double changed = 0, most = 0;
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    const Vec6 now = twist_of(mechanism, numbers_[i], state);
    changed = std::max(changed, (twists_[i] - now).norm());
    most = std::max(most, twists_[i].norm());
    set_twist(mechanism, numbers_[i], twists_[i], state);
  }
  return changed <= kUnchanged * most;
}

bool BodyContacts::rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
                           std::vector<double>& state) {
  if (touches_.empty()) return false;
  const bool struck = find_rebounds(mechanism, dt, before);
  for (BodyTouch& at : touches_) at.given /= dt;
  push(mechanism, state);
  return struck;
}

void BodyContacts::stop(const Mechanism& mechanism, double time, double dt,
                        std::vector<double>& state) {
  find(mechanism, time, dt, state);
  if (touches_.empty()) return;
  use_friction(false);
  shift(mechanism, state);
  find_rebounds(mechanism, dt, state);
  use_friction(true);
  for (BodyTouch& at : touches_) at.given.setZero();
  push(mechanism, state);
}

Vec3 velocity_at(const Vec6& twist, const Vec3& arm) {
  return twist.head<3>() + twist.tail<3>().cross(arm);
}

Vec6 wrench(const Vec3& impulse, const Vec3& arm) {
  Vec6 made;
  made << impulse, arm.cross(impulse);
  return made;
}

Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia) {
  Mat6 m = Mat6::Zero();
  m.topLeftCorner<3, 3>() = inverse_mass * Mat3::Identity();
  m.bottomRightCorner<3, 3>() = inverse_inertia;
  return m;
}

Mat3 mobility(const Mat6& twists, const Vec3& arm, const Vec3& pulled) {
  const Mat3 at = cross_matrix(arm), by = cross_matrix(pulled);
  return twists.topLeftCorner<3, 3>() + twists.topRightCorner<3, 3>() * by -
         at * twists.bottomLeftCorner<3, 3>() - at * twists.bottomRightCorner<3, 3>() * by;
}

void BodyMobility::set_apart(std::span<const Mat6> own) {
  own_.assign(own.begin(), own.end());
  place_.assign(own.size(), {});
  blocks_.clear();
  bodies_.clear();
}

void BodyMobility::set(std::span<const std::uint32_t> bodies, std::span<const Mat6> blocks) {
  const std::size_t count = bodies.size(), first = blocks_.size(), listed = bodies_.size();
  for (std::size_t i = 0; i < count; ++i) own_[bodies[i]] = blocks[i * count + i];
  if (count < 2) return;
  for (std::size_t i = 0; i < count; ++i) place_[bodies[i]] = {first, i, count, listed};
  blocks_.insert(blocks_.end(), blocks.begin(), blocks.end());
  bodies_.insert(bodies_.end(), bodies.begin(), bodies.end());
}

Vec3 passing(std::span<const Vec6> twists, const BodyTouch& at) {
  const Vec3 moves = velocity_at(twists[at.body], at.arm);
  return at.other == kNoBody ? moves : Vec3(moves - velocity_at(twists[at.other], at.other_arm));
}

void set(BodyTouch& at, Touch::State state, const Vec3& given) {
  at.given = given;
  at.touch.state = state;
  at.touch.push = at.touch.normal.dot(given);
  at.touch.friction = given - at.touch.push * at.touch.normal;
}

std::uint32_t Clusters::first_of(std::uint32_t body) {
  while (root_[body] != body) body = root_[body] = root_[root_[body]];
  return body;
}

void Clusters::find(std::size_t bodies, std::span<const BodyTouch> touches) {
  root_.resize(bodies);
  std::iota(root_.begin(), root_.end(), 0);
  for (const BodyTouch& at : touches) {
    if (at.other == kNoBody) continue;
    const std::uint32_t a = first_of(at.body), b = first_of(at.other);
    root_[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t b = 0; b < root_.size(); ++b) root_[b] = first_of(b);
}

namespace {

/// A capsule as a solid in the frame of its body.
void make_solid(const BodyCapsule& capsule, BodyMeeting& meeting) {
  const Vec3 way = capsule.to - capsule.from;
  const double length = way.norm();
  meeting.place.position = (capsule.from + capsule.to) / 2;
  meeting.shape = sphere_shape(capsule.radius);
  if (!(length > 0)) return;
  meeting.shape = capsule_shape(capsule.radius, length);
  meeting.place.rotation = rotation_between(Vec3::UnitY(), way);
}

/// The number of each body among the free ones.
std::vector<std::uint32_t> numbers_of_free_bodies(const World& world) {
  std::vector<std::uint32_t> number(world.bodies.size(), kNoBody);
  std::uint32_t free = 0;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (!world.bodies[b].driven()) number[b] = free++;
  }
  return number;
}

}  // namespace

std::vector<BodyCapsule> capsules_of_free_bodies(const World& world) {
  std::vector<BodyCapsule> capsules;
  for (const Body& body : world.bodies) {
    if (body.driven()) continue;
    BodyCapsule capsule = body.capsule;
    capsule.from -= body.mass_properties.centre;
    capsule.to -= body.mass_properties.centre;
    capsules.push_back(capsule);
  }
  return capsules;
}

void add_meetings(std::uint32_t body, std::uint64_t category, std::span<const Obstacle> obstacles,
                  std::vector<BodyMeeting>& meetings) {
  for (std::uint32_t o = 0; o < obstacles.size(); ++o) {
    const Obstacle& with = obstacles[o];
    if (!with.touches(category)) continue;
    meetings.push_back({.body = body,
                        .obstacle = o,
                        .shape = with.shape,
                        .place = {},
                        .static_friction = with.static_friction,
                        .kinetic_friction = with.kinetic_friction,
                        .restitution = with.restitution});
  }
}

std::vector<BodyMeeting> meetings_of_bodies(const World& world, std::span<const Obstacle> obstacles,
                                            std::span<const BodyPair> pairs) {
  const std::vector<BodyCapsule> capsules = capsules_of_free_bodies(world);
  const std::vector<std::uint32_t> number = numbers_of_free_bodies(world);
  std::vector<BodyMeeting> meetings;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (number[b] == kNoBody || !world.bodies[b].capsule.touches()) continue;
    add_meetings(number[b], world.bodies[b].capsule.category, obstacles, meetings);
    for (const BodyPair& pair : pairs) {
      if (pair.a != b) continue;
      BodyMeeting& made = meetings.emplace_back();
      made.body = number[b];
      made.other = number[pair.b];
      make_solid(capsules[made.other], made);
      made.static_friction = pair.static_friction;
      made.kinetic_friction = pair.kinetic_friction;
      made.restitution = pair.restitution;
    }
  }
  return meetings;
}

std::vector<BodyMeeting> meetings_of_beads(const World& world, const Mechanism& mechanism,
                                           std::span<const BeadPair> pairs) {
  const std::vector<BodyCapsule> capsules = capsules_of_free_bodies(world);
  const std::vector<std::uint32_t> number = numbers_of_free_bodies(world);
  std::vector<std::size_t> first{0};
  for (const Connector& connector : world.connectors) {
    first.push_back(first.back() + connector.particles());
  }
  std::vector<BodyMeeting> meetings;
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;  // what is joined is of two connectors
  for (const BeadPair& pair : pairs) {
    BodyMeeting made;
    made.other = number[pair.body];
    make_solid(capsules[made.other], made);
    made.static_friction = pair.static_friction;
    made.kinetic_friction = pair.kinetic_friction;
    made.restitution = pair.restitution;
    for (std::size_t p = first[pair.connector]; p < first[pair.connector + 1]; ++p) {
      made.body = small(mechanism.leader(p));
      if (mechanism.inverse_mass()[made.body] == 0) continue;
      if (known.insert({made.body, made.other}).second) meetings.push_back(made);
    }
  }
  return meetings;
}

std::vector<std::uint32_t> bodies_together(std::span<const BodyMeeting> meetings,
                                           std::size_t bodies) {
  std::vector<BodyTouch> touches;
  for (const BodyMeeting& meeting : meetings) {
    if (meeting.other == kNoBody) continue;
    touches.push_back({.body = meeting.body, .other = meeting.other, .touch = {}});
  }
  std::vector<std::uint32_t> numbers;
  if (touches.empty()) return numbers;
  Clusters clusters;
  clusters.find(bodies, touches);
  for (std::uint32_t b = 0; b < bodies; ++b) numbers.push_back(clusters.of(b));
  return numbers;
}

Pose pose_of_solid(const BodyMeeting& meeting, const Vec3& centre, const Quat& rotation) {
  return {centre + rotation * meeting.place.position, rotation * meeting.place.rotation};
}

namespace {

constexpr double kSlack = 1e-13;      // of the speeds: a law broken by rounding
constexpr double kSeveral = 1000;     // times that, of bodies that touch each other
constexpr int kSweeps = 400;          // of Gauss-Seidel
constexpr int kNewtons = 8;           // from states that seem to be right
constexpr double kDependent = 1e-11;  // of the largest pivot: touches that say the same

constexpr double kLeastPart = 1e-6;  // of what presses most
constexpr double kFirst = 1e5;       // normals before friction, where both cannot be had
constexpr double kYields = 1e-3;     // of what friction could change: what sticks may part by less
constexpr double kHeldBack = 1e-6;   // of the inverse mass
constexpr double kImmobile = 1e-12;  // of the mobility of the free body

Eigen::Index row(std::size_t touch) {
  return 3 * static_cast<Eigen::Index>(touch);
}

}  // namespace

std::uint32_t BodySystem::index_of(std::uint32_t body, std::span<const Mat6> mobility) {
  const auto found = std::ranges::find(bodies_, body);
  const auto index = static_cast<std::uint32_t>(found - bodies_.begin());
  if (found == bodies_.end()) {
    bodies_.push_back(body);
    mobility_.push_back(mobility[body]);
  }
  return index;
}

void BodySystem::assemble(std::span<const Mat6> mobility, std::span<const BodyTouch> touches,
                          double share) {
  share_ = share;
  bodies_.clear();
  mobility_.clear();
  sides_.clear();
  inverse_mass_.clear();
  for (const BodyTouch& at : touches) {
    auto& [own, other] = sides_.emplace_back();
    own.index = index_of(at.body, mobility);
    own.lever.leftCols<3>().setIdentity();
    own.lever.rightCols<3>() = -cross_matrix(at.arm);
    double inverse_mass = mobility[at.body](0, 0);
    if (at.other != kNoBody) {
      other.index = index_of(at.other, mobility);
      other.lever.leftCols<3>() = -Mat3::Identity();
      other.lever.rightCols<3>() = cross_matrix(at.other_arm);
      inverse_mass += mobility[at.other](0, 0);
    }
    inverse_mass_.push_back(share * inverse_mass);
  }
  several_ = bodies_.size() > 1;
  linked_ = false;
  const Eigen::Index size = row(touches.size());
  coupling_.resize(size, size);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
      Mat3 sum = Mat3::Zero();
      for (const Side& at : sides_[i]) {
        for (const Side& by : sides_[k]) {
          if (at.index == kNoBody || at.index != by.index) continue;
          sum += share * at.lever * mobility_[at.index] * by.lever.transpose();
        }
      }
      coupling_.block<3, 3>(row(i), row(k)) = sum;
    }
  }
}

void BodySystem::assemble(const Eigen::MatrixXd& coupling, std::span<const double> inverse_mass) {
  share_ = 1;
  bodies_.clear();
  several_ = linked_ = true;
  coupling_ = coupling;
  inverse_mass_.assign(inverse_mass.begin(), inverse_mass.end());
}

/// 1/kg: in sweeps a touch that links hold changes what it gives as if it moved by so much more.
double BodySystem::held_back(std::size_t i) const {
  return linked_ ? kHeldBack * inverse_mass_[i] : 0;
}

Mat3 BodySystem::coupling(std::size_t i, std::size_t k) const {
  return coupling_.block<3, 3>(row(i), row(k));
}

Vec3 BodySystem::velocity(std::size_t i, std::span<const Vec3> bare) const {
  Vec3 sum = bare[i];
  for (std::size_t k = 0; k < given_.size(); ++k) sum += coupling(i, k) * given_[k];
  return sum;
}

// One touch of bodies, where all others give what they do.

namespace {

constexpr double kClosed = 1e-13;  // of the speeds: less is no approach but rounding
constexpr int kTurns = 20;         // of Newton's method on the way of sliding
constexpr int kWays = 32;          // looked at where that fails
constexpr int kHalvings = 60;

}  // namespace

/// One touch alone, where the others give what they do. False: friction jams it.
bool BodySystem::solve_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const double short_of = touch.least - n.dot(bare);
  if (!(short_of > kClosed * (1 + bare.norm()))) {
    set(at, Touch::State::open, Vec3::Zero());
    return true;
  }
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  if (touch.stick == 0 && touch.slide == 0) {
    set(at, Touch::State::slides, short_of / n.dot(mobility * n) * n);
    return true;
  }
  if (at.ahead.isZero(0)) {
    const Mat3 tangent = across(n);
    const Vec3 slip = tangent * (bare - touch.surface);
    const Mat3 creeps = mobility + creep_ * inverse_mass_[i] * tangent;
    const Vec3 given = creeps.partialPivLu().solve(short_of * n - slip);
    const double push = n.dot(given);
    if (push > 0 && (given - push * n).norm() <= friction_of(touch, slip) * push) {
      set(at, Touch::State::sticks, given);
      return true;
    }
  }
  return slide_one(i, bare, at);
}

/// The way of sliding under which friction is against it: a root of one angle.
bool BodySystem::slide_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  const double short_of = touch.least - n.dot(bare);
  const auto given = [&](const Vec3& way) -> Vec3 {
    const Vec3 force = n - touch.slide * way;
    const double gives = n.dot(mobility * force);
    return gives > 0 ? Vec3(short_of / gives * force) : Vec3(Vec3::Zero());
  };
  const auto slip = [&](const Vec3& way) -> Vec3 {
    return across(n) * (bare + mobility * given(way) - touch.surface);
  };
  if (!at.ahead.isZero(0)) {
    set(at, Touch::State::slides, given(at.ahead));
    return touch.push > 0;
  }
  Vec3 first = across(n) * (bare - touch.surface);
  if (!(first.norm() > 0)) first = touch.sliding - n.dot(touch.sliding) * n;
  if (!(first.norm() > 0)) first = n.unitOrthogonal();
  first.normalize();
  const Vec3 aside = n.cross(first);
  Vec3 way = first;
  for (int turn = 0; turn < kTurns; ++turn) {  // mostly a contraction
    const Vec3 goes = slip(way);
    const double speed = goes.norm();
    if (!(speed > 0) || !(way.dot(goes) > 0)) break;
    const Vec3 next = goes / speed;
    const double moved = (next - way).norm();
    way = next;
    if (moved > 1e-15) continue;
    set(at, Touch::State::slides, given(way));
    return touch.push > 0;
  }
  const auto towards = [&](double angle) -> Vec3 {
    return std::cos(angle) * first + std::sin(angle) * aside;
  };
  const auto off = [&](double angle) {
    return slip(towards(angle)).dot(towards(angle + std::numbers::pi / 2));
  };
  constexpr double kStep = 2 * std::numbers::pi / kWays;
  for (int k = 0; k < kWays; ++k) {
    double low = (k - 0.5) * kStep, high = low + kStep;
    const double at_low = off(low);
    if (at_low * off(high) > 0) continue;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = (low + high) / 2;
      (at_low * off(middle) > 0 ? low : high) = middle;
    }
    way = towards((low + high) / 2);
    const Vec3 found = given(way);
    if (!(n.dot(found) > 0) || !(slip(way).dot(way) >= 0)) continue;
    set(at, Touch::State::slides, found);
    return true;
  }
  return false;
}

// All touches at once.

/// The laws of the touches in their states, by what is given and by the velocities without.
void BodySystem::linearize(std::span<const Vec3> bare, std::span<const BodyTouch> touches) {
  const Eigen::Index size = row(touches.size());
  matrix_.setZero(size, size);
  slope_.setZero(size, size);
  error_.setZero(size);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i].touch;
    const Eigen::Index at = row(i);
    if (touch.state == Touch::State::open) {
      matrix_.block<3, 3>(at, at).setIdentity();
      error_.segment<3>(at) = given_[i];
      continue;
    }
    const Vec3& n = touch.normal;
    const double inverse_mass = inverse_mass_[i];
    const Mat3 tangent = across(n);
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = tangent * (moves - touch.surface);
    Mat3 by_velocity = n * n.transpose() / inverse_mass, by_given;
    Vec3 error = (n.dot(moves) - touch.least) / inverse_mass * n;
    if (touch.state == Touch::State::sticks) {
      by_velocity = Mat3::Identity() / inverse_mass;
      by_given = creep_ * tangent;
      error += slip / inverse_mass + creep_ * tangent * given_[i];
    } else {
      const double speed = slip.norm();
      const bool known = !touches[i].ahead.isZero(0);
      const Vec3 way =
          known ? touches[i].ahead : (speed > 0 ? Vec3(slip / speed) : Vec3(Vec3::Zero()));
      const double push = n.dot(given_[i]);
      by_given = tangent + touch.slide * way * n.transpose();
      error += tangent * given_[i] + touch.slide * push * way;
      if (!known && speed > 0) {
        by_velocity += touch.slide * push / speed * (tangent - way * way.transpose());
      }
    }
    slope_.block<3, 3>(at, at) = by_velocity;
    error_.segment<3>(at) = error;
    matrix_.block<3, 3>(at, at) += by_given;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      matrix_.block<3, 3>(at, row(k)) += by_velocity * coupling(i, k);
    }
  }
}

/// The touches' impulses by the linear laws. Where these leave the friction of touches that stick
/// undetermined, each takes a part in proportion to its present normal impulse.
std::vector<Vec3> BodySystem::solve_linear(std::span<const BodyTouch> touches) const {
  double most = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    most = std::max(most, touches[i].touch.normal.dot(given_[i]));
  }
  const Eigen::Index size = row(touches.size());
  Eigen::VectorXd right = -error_;
  Eigen::MatrixXd weights = Eigen::MatrixXd::Identity(size, size), rows = weights;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Vec3& n = touches[i].touch.normal;
    right += matrix_.middleCols<3>(row(i)) * given_[i];
    const double part = most > 0 ? std::max(n.dot(given_[i]) / most, kLeastPart) : 1;
    weights.block<3, 3>(row(i), row(i)) = n * n.transpose() + part * across(n);
    rows.block<3, 3>(row(i), row(i)) = kFirst * n * n.transpose() + across(n);
  }
  LeastSquares decomposed(kDependent);
  decomposed.compute(rows * matrix_ * weights);
  const Eigen::VectorXd found = weights * decomposed.solve(Eigen::VectorXd(rows * right));
  std::vector<Vec3> given;
  for (std::size_t i = 0; i < touches.size(); ++i) given.push_back(found.segment<3>(row(i)));
  return given;
}

/// Newton's method on what is given, with the states as they are; whether that obeys the laws.
bool BodySystem::polish(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  const std::vector<Vec3> kept = given_;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kNewtons; ++i) {
    check_stop();
    linearize(bare, touches);
    const std::vector<Vec3> next = solve_linear(touches);
    double most = 0, change = 0;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      most = std::max(most, next[k].norm());
      change = std::max(change, (next[k] - given_[k]).norm());
    }
    if (!std::isfinite(change)) break;
    given_ = next;
    if (change <= 1e-15 * most || change > before / 2) break;
    before = change;
  }
  if (is_solved(bare, touches)) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
      set(touches[k], touches[k].touch.state, given_[k]);
    }
    return true;
  }
  tried_ = given_;
  given_ = kept;
  return false;
}

/// Whether the touches obey the laws in the states that they had last: of several bodies that is
/// found sooner than from sticking.
bool BodySystem::goes_on(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  const auto is_open = [](const BodyTouch& at) { return at.touch.state == Touch::State::open; };
  return !std::ranges::all_of(touches, is_open) && polish(bare, touches);
}

/// Whether the body is held at all that touches it: where that is a solution, static friction may
/// be more than kinetic, and no way through states that slide leads there.
bool BodySystem::sticks(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  if (touches.size() < 2) return false;
  for (const BodyTouch& at : touches) {
    if (at.touch.stick == 0 || !at.ahead.isZero(0)) return false;
  }
  const std::vector<BodyTouch> kept(touches.begin(), touches.end());
  for (BodyTouch& at : touches) at.touch.state = Touch::State::sticks;
  if (polish(bare, touches)) return true;
  // Of several bodies some may be about to part, and the others stick.
  for (bool opens = several_; opens;) {
    opens = false;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const bool pulls = !(touches[i].touch.normal.dot(tried_[i]) > 0);
      if (touches[i].touch.state == Touch::State::open || !pulls) continue;
      touches[i].touch.state = Touch::State::open;
      opens = true;
    }
    if (opens && polish(bare, touches)) return true;
  }
  std::ranges::copy(kept, touches.begin());
  return false;
}

bool BodySystem::is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const {
  double speed = 1;
  for (const Vec3& moves : bare) speed = std::max(speed, moves.norm());
  const double slack = (several_ ? kSeveral : 10) * kSlack * speed;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i].touch;
    const double inverse_mass = inverse_mass_[i], weak = slack / inverse_mass;
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = across(touch.normal) * (moves - touch.surface);
    const double past = touch.normal.dot(moves) - touch.least;
    const double push = touch.normal.dot(given_[i]);
    const double friction = (given_[i] - push * touch.normal).norm();
    if (past < -slack || push < -weak) return false;
    if (touch.state == Touch::State::open) continue;
    if (past > slack) return false;
    if (touch.state == Touch::State::sticks) {
      const Vec3 slips = across(touch.normal) * (bare[i] - touch.surface);
      if (friction > friction_of(touch, slips) * push + weak) return false;
      const double yields =
          touches.size() > 1 && !linked_ ? kYields * inverse_mass * touch.stick * push : 0;
      if (slip.norm() > slack + yields + 2 * creep_ * inverse_mass * friction) return false;
    } else if (std::abs(friction - touch.slide * push) > weak ||
               slip.dot(given_[i] - push * touch.normal) > weak * (slack + slip.norm())) {
      if (touches[i].ahead.isZero(0)) return false;
    }
  }
  return true;
}

bool BodySystem::solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep) {
  if (touches.empty()) return true;
  creep_ = creep;
  bare_.assign(bare.begin(), bare.end());
  given_.clear();
  for (const BodyTouch& at : touches) given_.push_back(at.given);
  if (several_ && goes_on(bare, touches)) return true;
  if (sticks(bare, touches)) return true;
  const auto states = [&] {
    std::size_t number = 0;
    for (const BodyTouch& at : touches) {
      number = 3 * number + static_cast<std::size_t>(at.touch.state);
    }
    return number;
  };
  std::size_t before = states();
  int same = 0, wait = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    check_stop();
    bool finds = true;
    double change = 0, most = 0;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const Vec3 others = velocity(i, bare) - coupling(i, i) * given_[i] - held_back(i) * given_[i];
      finds = solve_one(i, others, touches[i]) && finds;
      change = std::max(change, (touches[i].given - given_[i]).norm());
      given_[i] = touches[i].given;
      most = std::max(most, given_[i].norm());
    }
    if (!finds && touches.size() == 1) return false;
    if (finds && !linked_ && (touches.size() == 1 || change <= 1e-16 * most)) return true;
    const std::size_t now = states();
    same = now == before ? same + 1 : 0;
    before = now;
    if (!finds || same < wait) continue;
    if (polish(bare, touches)) return true;
    same = 0;
    wait *= 2;
  }
  return is_solved(bare, touches);
}

void BodySystem::hold(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  if (touches.empty()) return;
  creep_ = 0;
  bare_.assign(bare.begin(), bare.end());
  given_.assign(touches.size(), Vec3::Zero());
  for (int i = 0; i < 2; ++i) {  // the second time with what presses known
    linearize(bare, touches);
    given_ = solve_linear(touches);
  }
  for (std::size_t i = 0; i < touches.size(); ++i) {
    set(touches[i], touches[i].touch.state, given_[i]);
  }
}

Vec6 BodySystem::twist(std::span<const BodyTouch> touches, std::size_t index) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (const Side& side : sides_[i]) {
      if (side.index == index) sum += side.lever.transpose() * touches[i].given;
    }
  }
  return mobility_[index] * sum;
}

void BodySystem::couple(std::span<const BodyTouch> touches, BodyMobility& mobility) {
  linearize(bare_, touches);
  LeastSquares decomposed(kDependent);
  decomposed.compute(matrix_);
  const std::size_t count = bodies_.size();
  blocks_.assign(count * count, Mat6::Zero());
  std::vector<Eigen::MatrixXd> levers(count);
  for (std::size_t b = 0; b < count; ++b) {
    levers[b].setZero(row(touches.size()), 6);
    for (std::size_t i = 0; i < touches.size(); ++i) {
      for (const Side& side : sides_[i]) {
        if (side.index == b) levers[b].block<3, 6>(row(i), 0) = side.lever;
      }
    }
  }
  for (std::size_t b = 0; b < count; ++b) {
    const Eigen::MatrixXd gives = decomposed.solve(Eigen::MatrixXd(slope_ * levers[b]));
    for (std::size_t a = 0; a < count; ++a) {
      const Mat6 free = a == b ? mobility_[a] : Mat6(Mat6::Zero());
      const Mat6 found =
          free - share_ * mobility_[a] * (levers[a].transpose() * gives) * mobility_[b];
      // A body that cannot move at all does not move by rounding either.
      const double most =
          std::sqrt(mobility_[a].cwiseAbs().maxCoeff() * mobility_[b].cwiseAbs().maxCoeff());
      if (found.cwiseAbs().maxCoeff() > kImmobile * most) blocks_[a * count + b] = found;
    }
  }
  mobility.set(bodies_, blocks_);
}

}  // namespace taut::contact
