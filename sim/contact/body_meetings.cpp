#include "sim/contact/body_meetings.h"

#include <algorithm>
#include <set>
#include <utility>

#include "sim/contact/clusters.h"
#include "sim/motion/rotation.h"

namespace taut::contact {
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
