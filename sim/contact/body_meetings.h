// The possible touches of free bodies' capsules: with obstacles, and with each other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/contact/body_mobility.h"
#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut::contact {

/// A free body whose capsule may touch an obstacle or, as a solid that moves with it, the capsule
/// of another. Free bodies are numbered among themselves, as Mechanism does.
struct BodyMeeting {
  std::uint32_t body = 0, other = kNoBody;  // kNoBody: an obstacle
  std::uint32_t obstacle = 0;               // of no account where there is another body
  Shape shape;                              // of what it touches
  Pose place;  // of the shape: in the axes of the other body, from its centre of mass
  double static_friction = 0, kinetic_friction = 0, restitution = 0;
};

/// The capsules of all free bodies, from their centres of mass.
std::vector<BodyCapsule> capsules_of_free_bodies(const World& world);

/// Adds those of a body, or of what stands for one, with the obstacles that its category touches.
void add_meetings(std::uint32_t body, std::uint64_t category, std::span<const Obstacle> obstacles,
                  std::vector<BodyMeeting>& meetings);

/// All that these may touch, in order of the bodies; `pairs` of the world's bodies.
std::vector<BodyMeeting> meetings_of_bodies(const World& world, std::span<const Obstacle> obstacles,
                                            std::span<const BodyPair> pairs);

/// The same of beads that may touch free bodies, as `pairs` says, and that nothing holds: `body` is
/// the mechanism's point that stands for the bead.
std::vector<BodyMeeting> meetings_of_beads(const World& world, const Mechanism& mechanism,
                                           std::span<const BeadPair> pairs);

/// Per free body, the number of those that may touch each other in whatever way; empty where no
/// body may touch another.
std::vector<std::uint32_t> bodies_together(std::span<const BodyMeeting> meetings,
                                           std::size_t bodies);

/// Where the solid is that another body is, which has that centre of mass and rotation.
Pose pose_of_solid(const BodyMeeting& meeting, const Vec3& centre, const Quat& rotation);

}  // namespace taut::contact
