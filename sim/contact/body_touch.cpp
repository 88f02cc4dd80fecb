#include "sim/contact/body_touch.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "sim/motion/rotation.h"

namespace taut::contact {

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

}  // namespace taut::contact
