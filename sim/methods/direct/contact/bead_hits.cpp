// Hits of beads and bodies on their way through a step.
#include <algorithm>
#include <array>

#include "sim/methods/direct/contact/bead_touches.h"
#include "sim/methods/direct/contact/body_way.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

}  // namespace

const std::vector<BeadTouches::Hit>& BeadTouches::hits(const Step& step,
                                                       const std::vector<double>& next,
                                                       std::span<const Vec3> mean) {
  hits_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) sweep(step, next, mean, m);
  return hits_;
}

/// Notes where on its way a bead enters a body.
void BeadTouches::sweep(const Step& step, const std::vector<double>& next,
                        std::span<const Vec3> mean, std::uint32_t index) {
  const contact::BodyMeeting& meeting = meetings_[index];
  const Mechanism& mechanism = step.mechanism;
  const Vec3 from = ConstMap(&step.state[mechanism.position(meeting.body)]);
  const Vec3 straight = step.h * ConstMap(&step.state[mechanism.velocity(meeting.body)]);
  const Vec3 bend = step.h * mean[meeting.body] - straight;
  const contact::Vec6 twist = twist_at(&step.state[mechanism.twist(meeting.other)]);
  BodyWay way(&step.state[mechanism.pose(meeting.other)], &next[mechanism.pose(meeting.other)],
              twist, step.h);
  const double passed = (straight - step.h * way.velocity).norm() + 2 * (bend - way.bend).norm();
  if (is_far(step, index, passed)) return;  // which does not matter how the body turns
  if (is_known(index)) return;
  way.bend_turn(twist.tail<3>());
  const double far = passed + way.turned(bounding_radius_[meeting.other]);
  const Vec3 last = ConstMap(&next[mechanism.position(meeting.body)]);
  const double at_start = gap_of(meeting, index, from, way.from).distance;
  if (at_start > far) return;
  const auto bead = [&](double share) -> Vec3 {
    return from + share * straight + share * share * bend;
  };
  const auto gap_at_share = [&](double share) {
    return gap_of(meeting, index, bead(share), way.at(share).data()).distance;
  };
  const double at_end = gap_of(meeting, index, last, &next[mechanism.pose(meeting.other)]).distance;
  const Entry entry = find_entry(at_start, at_end, far, gap_at_share);
  if (entry.share > 1) return;
  const double when = entry.stays ? 0 : entry.share;
  const std::array<double, 7> pose = way.at(when);
  const Vec3 place = bead(when), normal = gap_of(meeting, index, place, pose.data()).normal;
  const Quat back = quaternion(&pose[3]).conjugate();
  hits_.push_back({.share = entry.share,
                   .meeting = index,
                   .passes = entry.passes,
                   .anchor = back * (place - ConstMap(pose.data())),
                   .side = back * normal});
}

}  // namespace taut::direct
