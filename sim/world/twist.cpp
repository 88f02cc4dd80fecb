#include "sim/world/twist.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/motion/rotation.h"
#include "sim/world/joined.h"

namespace taut {

void CarriedFrame::carry(const Vec3& direction) {
  const Vec3 axis = direction_.cross(direction);
  const double cosine = 1 + direction_.dot(direction);  // twice that of half of the angle, squared
  const double scale = 1 / std::sqrt(cosine * cosine + axis.squaredNorm());
  frame_ = Quat(scale * cosine, scale * axis.x(), scale * axis.y(), scale * axis.z()) * frame_;
  direction_ = direction;
}

double CarriedFrame::turn_to(const Quat& frame) const {
  const Quat turn = frame_.conjugate() * frame;
  return turn.w() < 0 ? 2 * std::atan2(-turn.x(), -turn.w()) : 2 * std::atan2(turn.x(), turn.w());
}

Quat frame_along(const Vec3& direction) {
  // No frame is half a turn away from the one that it is made of.
  const Quat behind(0, 0, 1, 0);  // takes x to -x
  return direction.x() < 0 ? rotation_between(-Vec3::UnitX(), direction) * behind
                           : rotation_between(Vec3::UnitX(), direction);
}

bool is_loop(const World& world, std::size_t connector) {
  const Joint* joint = find_joint(world, connector, 0);
  return joint && std::ranges::any_of(joint->particles, [&](const Joint::Particle& at) {
           return at.connector == connector && at.particle == world.connectors[connector].links();
         });
}

bool carries_twist(const World& world, std::size_t index) {
  const Connector& connector = world.connectors[index];
  const auto resists = [](const Section& section) { return section.twisting_stiffness > 0; };
  if (connector.sections.empty() || !std::ranges::all_of(connector.sections, resists)) return false;
  std::size_t ends = 0, between = 0;
  for (const Hold& hold : connector.holds) {
    if (hold.clamp.isZero(0)) continue;
    ++(hold.particle == 0 || hold.particle == connector.links() ? ends : between);
  }
  const bool loop = is_loop(world, index);
  if (!loop && ends < 2) return false;
  if (between > 0 || (loop && ends > 0)) {
    throw std::invalid_argument("connector " + connector.name +
                                " resists twist and is clamped between its ends");
  }
  return true;
}

ClampFrame clamp_frame(const World& world, const Hold& hold, double time) {
  const Vec3 own = hold.clamp.normalized();
  ClampFrame found{.frame = frame_along(own)};
  if (hold.turn) {
    const FrameMotion turned = hold.turn->at(time);
    found.turn = turned.position.x();
    found.turn_rate = turned.velocity.x();
  }
  if (hold.to.kind == Attachment::Kind::fixed) return found;
  if (!is_prescribed(world, hold.to)) {
    const Body& body = world.bodies[hold.to.body];
    found.frame = body.rotation * found.frame;
    found.spin = body.spin.dot(body.rotation * own);
    return found;
  }
  const FrameMotion frame = hold.to.kind == Attachment::Kind::path
                                ? hold.to.path->at(time)
                                : driven_frame(world.bodies[hold.to.body], time);
  found.frame = frame.rotation * found.frame;
  found.spin = frame.spin.dot(frame.rotation * own);
  return found;
}

double end_turn(const World& world, std::size_t index) {
  const Connector& connector = world.connectors[index];
  const auto link = [&](std::size_t k) -> Vec3 {
    return (connector.position[k + 1] - connector.position[k]).normalized();
  };
  Quat from = frame_along(link(0)), to = from;
  if (!is_loop(world, index)) {
    from = clamp_frame(world, connector.holds.front(), world.time).frame;
    to = clamp_frame(world, connector.holds.back(), world.time).frame;
  }
  CarriedFrame carried(from, from * Vec3::UnitX());
  for (std::size_t k = 0; k < connector.links(); ++k) carried.carry(link(k));
  carried.carry(to * Vec3::UnitX());
  return carried.turn_to(to);
}

}  // namespace taut
