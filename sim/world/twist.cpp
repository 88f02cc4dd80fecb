#include "sim/world/twist.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/world/rotation.h"

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

bool carries_twist(const Connector& connector) {
  const auto resists = [](const Section& section) { return section.twisting_stiffness > 0; };
  if (connector.sections.empty() || !std::ranges::all_of(connector.sections, resists)) return false;
  if (connector.holds.size() < 2) return false;
  const Hold &from = connector.holds.front(), &to = connector.holds.back();
  if (from.particle != 0 || to.particle != connector.links()) return false;
  if (from.clamp.isZero(0) || to.clamp.isZero(0)) return false;
  const bool between = std::any_of(connector.holds.begin() + 1, connector.holds.end() - 1,
                                   [](const Hold& hold) { return !hold.clamp.isZero(0); });
  if (between) {
    throw std::invalid_argument("connector " + connector.name +
                                " resists twist and is clamped between its ends");
  }
  return true;
}

ClampFrame clamp_frame(const World& world, const Hold& hold, double time) {
  const Vec3 own = hold.clamp.normalized();
  // No frame is half a turn away from the one that it is made of.
  const Quat behind(0, 0, 1, 0);  // takes x to -x
  ClampFrame found{.frame = own.x() < 0 ? rotation_between(-Vec3::UnitX(), own) * behind
                                        : rotation_between(Vec3::UnitX(), own)};
  if (hold.turn) {
    const FrameMotion turned = hold.turn->at(time);
    found.turn = turned.position.x();
    found.turn_rate = turned.velocity.x();
  }
  if (hold.to.kind == Attachment::Kind::fixed) return found;
  const FrameMotion frame = hold.to.kind == Attachment::Kind::path
                                ? hold.to.path->at(time)
                                : driven_frame(world.bodies[hold.to.body], time);
  found.frame = frame.rotation * found.frame;
  found.spin = frame.spin.dot(frame.rotation * own);
  return found;
}

double end_turn(const World& world, const Connector& connector) {
  const Quat from = clamp_frame(world, connector.holds.front(), world.time).frame;
  const Quat to = clamp_frame(world, connector.holds.back(), world.time).frame;
  CarriedFrame carried(from, from * Vec3::UnitX());
  for (std::size_t k = 0; k < connector.links(); ++k) {
    carried.carry((connector.position[k + 1] - connector.position[k]).normalized());
  }
  carried.carry(to * Vec3::UnitX());
  return carried.turn_to(to);
}

}  // namespace taut
