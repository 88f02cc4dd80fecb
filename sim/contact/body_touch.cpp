#include "sim/contact/body_touch.h"

namespace taut::contact {

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

}  // namespace taut::contact
