// Hits of bodies on their way through a step.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/body_way.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using contact::kNoBody;
using contact::Spot;
using contact::SpotGap;
using ConstMap = Eigen::Map<const Vec3>;

}  // namespace

const std::vector<BodyTouches::Hit>& BodyTouches::hits(const Step& step,
                                                       const std::vector<double>& next) {
  hits_.clear();
  for (std::uint32_t m = 0; m < meetings_.size(); ++m) {
    const Hit hit = sweep(step, next, m);
    if (hit.share <= 1) hits_.push_back(hit);
  }
  return hits_;
}

bool BodyTouches::meet_within(double share) const {
  return std::ranges::any_of(hits_, [&](const Hit& hit) {
    return hit.share <= share && meetings_[hit.meeting].other != kNoBody;
  });
}

bool BodyTouches::thrown_back_within(double share) const {
  return std::ranges::any_of(hits_, [&](const Hit& hit) {
    return hit.share <= share && meetings_[hit.meeting].restitution > 0;
  });
}

/// Where on its way a body enters what it may touch; a share above 1: nowhere.
BodyTouches::Hit BodyTouches::sweep(const Step& step, const std::vector<double>& next,
                                    std::uint32_t index) const {
  Hit hit{.share = 2, .meeting = index};
  const contact::BodyMeeting& meeting = meetings_[index];
  const Mechanism& mechanism = step.mechanism;
  const auto way_of = [&](std::uint32_t body) {
    return BodyWay(&step.state[mechanism.pose(body)], &next[mechanism.pose(body)],
                   twist_at(&step.state[mechanism.twist(body)]), step.h);
  };
  const std::uint32_t body = meeting.body;
  BodyWay way = way_of(body);
  std::optional<BodyWay> others;
  if (meeting.other != kNoBody) {
    others = way_of(meeting.other);
    way.bend_turn(twist_at(&step.state[mechanism.twist(body)]).tail<3>());
    others->bend_turn(twist_at(&step.state[mechanism.twist(meeting.other)]).tail<3>());
  }
  const Pose start = solid(meeting, step.start, mechanism, step.state);
  const Pose end = solid(meeting, step.end, mechanism, next);
  const auto frame = [&](double share) {
    if (others) {
      const std::array<double, 7> pose = others->at(share);
      return contact::pose_of_solid(meeting, ConstMap(pose.data()), quaternion(&pose[3]));
    }
    const Obstacle& with = step.obstacles[meeting.obstacle];
    return with.path ? with.frame(step.time + share * step.h).pose() : start;
  };
  const auto place = [&](double share) { return capsule(way.at(share).data(), body); };
  const contact::Capsule first = capsule(way.from, body);
  const contact::Capsule last = capsule(&next[mechanism.pose(body)], body);
  const double size = (first.to - first.from).norm();
  double far = 0;  // the largest way of any of its points in the other's frame
  if (others) {    // or by how much the distance of any two points may change
    far = step.h * (way.velocity - others->velocity).norm() + 2 * (way.bend - others->bend).norm() +
          way.turned(bounding_radius_[body]) + others->turned(bounding_radius_[meeting.other]);
  } else {
    const auto local = [](const Pose& pose, const Vec3& at) -> Vec3 {
      return pose.rotation.conjugate() * (at - pose.position);
    };
    const double turned = angle(end.rotation * start.rotation.conjugate()).norm();
    const double moved = (local(end, last.at(0.5)) - local(start, first.at(0.5))).norm();
    far = moved + way.bend.norm() + (way.turn.norm() + turned) * (size + bounding_radius_[body]);
  }
  const double around = size / 2 + far;
  if (contact::gap_at(meeting.shape, start, first, 0.5).distance > around) return hit;

  unsigned known = 0;
  for (std::size_t s = 0; s < contact::kSpots.size(); ++s) {
    if (is_known(index, s)) known |= 1u << s;
  }
  const auto spots_within = [&](double share, double distance) {
    const auto gaps = contact::all_gaps(meeting.shape, share < 1 ? frame(share) : end,
                                        share < 1 ? place(share) : last);
    unsigned spots = 0;
    for (std::size_t s = 0; s < gaps.size(); ++s) {
      const bool is_new = gaps[s].distinct && !(known & (1u << s));
      if (is_new && gaps[s].distance < distance) spots |= 1u << s;
    }
    return spots;
  };
  if (known != 0) {  // another of its spots
    const double entered = -kEntered * step.touching;
    hit.spots = spots_within(1, entered);
    if (hit.spots == 0) return hit;
    const auto inside = [&](double share) { return (spots_within(share, 0) & hit.spots) != 0; };
    const bool at_once = (spots_within(0, step.touching) & hit.spots) != 0;
    hit.share = at_once ? 1 : first_inside(0, 1, inside);
    return hit;
  }
  const auto gap_at_share = [&](double share) {
    return contact::least_gap(meeting.shape, frame(share), place(share));
  };
  const double at_start = contact::least_gap(meeting.shape, start, first);
  const double at_end = contact::least_gap(meeting.shape, end, last);
  const Entry entry = find_entry(at_start, at_end, far, gap_at_share);
  hit.share = entry.share;
  hit.passes = entry.passes;
  if (entry.share <= 1) {
    hit.spots = spots_within(entry.share, 2 * kReached);
  } else if (at_end < step.touching && at_end < at_start && meeting.restitution > 0) {
    // It gets there as the step ends: what is thrown back is so in this one, where it is.
    hit.spots = spots_within(1, step.touching);
    if (hit.spots != 0) hit.share = 1;
  }
  return hit;
}

}  // namespace taut::direct
