#include "sim/choreography/hand_frame.h"

#include "sim/motion/rotation.h"

namespace taut::choreography {
namespace {

/// The hold at the other end of the connector that the body hangs by.
const Attachment& lead(const World& world, std::size_t body) {
  const auto& holds = hanging_chain(world, body).holds;
  const bool first = holds[0].to.kind == Attachment::Kind::body && holds[0].to.body == body;
  return holds[first ? 1 : 0].to;
}

}  // namespace

std::shared_ptr<const Path> hand_path(const World& world, std::size_t body) {
  const Attachment& to = lead(world, body);
  return to.kind == Attachment::Kind::path ? to.path : world.bodies[to.body].path;
}

HandFrame::HandFrame(const World& world, std::size_t body, double pivot) : pivot_(pivot) {
  const Attachment& to = lead(world, body);
  const Vec3 lever =
      to.kind == Attachment::Kind::path ? to.point : Vec3(to.point - world.bodies[to.body].grip);
  const PathKey& last = hand_path(world, body)->keys().back();
  lever_ = lever.norm();
  rest_rotation_ = last.rotation;
  along_ = lever_ > 0 ? Vec3(last.rotation * lever / lever_) : Vec3::UnitY();
  rest_ = last.position + lever_ * along_;
}

TaylorSeries HandFrame::origin(const TaylorSeries& end) const {
  TaylorSeries origin = end;
  if (!turns()) {
    origin.col(0) -= lever_ * along_;
    return origin;
  }
  TaylorSeries from_pivot = end;
  from_pivot.col(0) -= rest_ - pivot_ * along_;
  return end - lever_ * unit_series(from_pivot);
}

Quat HandFrame::rotation(const Vec3& end) const {
  if (!turns()) return rest_rotation_;
  return (rotation_between(along_, end - rest_ + pivot_ * along_) * rest_rotation_).normalized();
}

}  // namespace taut::choreography
