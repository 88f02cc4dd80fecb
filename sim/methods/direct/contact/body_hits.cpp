// What bodies hit on their way through a step.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contact/body_touches.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using contact::Spot;
using contact::SpotGap;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kEntered = 1e-2;  // times touching: what else of a body that touches is inside

}  // namespace

const std::vector<BodyTouches::Hit>& BodyTouches::hits(const Step& step,
                                                       const std::vector<double>& next) {
  hits_.clear();
  for (std::uint32_t b = 0; b < capsules_.size(); ++b) {
    if (!capsules_[b].touches()) continue;
    for (std::uint32_t o = 0; o < step.obstacles.size(); ++o) {
      if (!step.obstacles[o].touches(capsules_[b].category)) continue;
      const Hit hit = sweep(step, next, b, o);
      if (hit.share <= 1) hits_.push_back(hit);
    }
  }
  return hits_;
}

/// Where on its way a body enters an obstacle; a share above 1: nowhere.
BodyTouches::Hit BodyTouches::sweep(const Step& step, const std::vector<double>& next,
                                    std::uint32_t body, std::uint32_t obstacle) const {
  Hit hit{.share = 2, .body = body, .obstacle = obstacle};
  const Obstacle& with = step.obstacles[obstacle];
  const Mechanism& mechanism = step.mechanism;
  const double *from = &step.state[mechanism.pose(body)], *to = &next[mechanism.pose(body)];
  const Pose start = step.start[obstacle].pose(), end = step.end[obstacle].pose();
  const Vec3 velocity = ConstMap(&step.state[mechanism.twist(body)]);
  const Vec3 way = ConstMap(to) - ConstMap(from), bend = way - step.h * velocity;
  const Quat rotation = quaternion(from + 3);
  const Vec3 turn = angle(quaternion(to + 3) * rotation.conjugate());
  const auto frame = [&](double share) {
    return with.path ? with.frame(step.time + share * step.h).pose() : start;
  };
  const auto place = [&](double share) {
    double pose[7];
    Eigen::Map<Vec3>{pose} = ConstMap(from) + share * step.h * velocity + share * share * bend;
    std::copy_n(from + 3, 4, pose + 3);
    rotate(share * turn, pose + 3);
    return capsule(pose, body);
  };
  // The largest way of any of its points in the obstacle's frame.
  const contact::Capsule first = capsule(from, body), last = capsule(to, body);
  const auto local = [](const Pose& pose, const Vec3& at) -> Vec3 {
    return pose.rotation.conjugate() * (at - pose.position);
  };
  const double turned = angle(end.rotation * start.rotation.conjugate()).norm();
  const double size = (first.to - first.from).norm();
  const double moved = (local(end, last.at(0.5)) - local(start, first.at(0.5))).norm();
  const double far = moved + bend.norm() + (turn.norm() + turned) * (size + reach_[body]);
  const double around = size / 2 + far;
  if (contact::gap_at(with.shape, start, first, 0.5).distance > around) return hit;

  unsigned known = 0;
  for (std::size_t s = 0; s < contact::kSpots.size(); ++s) {
    if (is_known(body, obstacle, s)) known |= 1u << s;
  }
  const auto spots_within = [&](double share, double distance) {
    const auto gaps = contact::all_gaps(with.shape, share < 1 ? frame(share) : end,
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
  const auto look = [&](double share) {
    return contact::least_gap(with.shape, frame(share), place(share));
  };
  const double at_start = contact::least_gap(with.shape, start, first);
  const double at_end = contact::least_gap(with.shape, end, last);
  const Entry entry = find_entry(at_start, at_end, far, look);
  hit.share = entry.share;
  hit.passes = entry.passes;
  if (entry.share <= 1) hit.spots = spots_within(entry.share, 2 * kReached);
  return hit;
}

}  // namespace taut::direct
