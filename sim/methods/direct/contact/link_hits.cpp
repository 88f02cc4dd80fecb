// Hits of links on their way through a step.
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/methods/direct/contact/entry.h"
#include "sim/methods/direct/contact/link_touches.h"

namespace taut::direct {
namespace {

using contact::Capsule;
using contact::Spot;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kLeaves = 1e-4;  // of the step: what is no farther after that has not left

/// A bead's way through a step: a parabola from its velocity at the start to where it ends.
struct BeadWay {
  BeadWay(const LinkTouches::Step& step, std::uint32_t point, const Vec3& mean)
      : from(ConstMap(&step.state[step.mechanism.position(point)])),
        straight(step.h * ConstMap(&step.state[step.mechanism.velocity(point)])),
        bend(step.h * mean - straight) {}

  Vec3 at(double share) const { return from + share * straight + share * share * bend; }

  Vec3 from, straight, bend;  // m
};

}  // namespace

const std::vector<LinkTouches::Hit>& LinkTouches::hits(const Step& step,
                                                       const std::vector<double>& next,
                                                       std::span<const Vec3> mean) {
  hits_.clear();
  for (std::uint32_t link = 0; link < links_.size(); ++link) {
    for (std::uint32_t o = 0; o < step.obstacles.size(); ++o) {
      if (step.obstacles[o].touches(links_[link].category)) sweep(step, next, mean, link, o);
    }
  }
  return hits_;
}

/// Notes where on its way a link enters an obstacle between its beads.
void LinkTouches::sweep(const Step& step, const std::vector<double>& next,
                        std::span<const Vec3> mean, std::uint32_t link, std::uint32_t index) {
  const Obstacle& with = step.obstacles[index];
  const std::uint32_t point = links_[link].first;
  const Capsule first = capsule(step, step.state, link), last = capsule(step, next, link);
  const Pose start = step.start[index].pose(), end = step.end[index].pose();
  const BeadWay from(step, point, mean[point]), to(step, point + 1, mean[point + 1]);
  const auto way_of = [&](const BeadWay& bead, const Vec3& ends) {
    const Vec3 before = start.rotation.conjugate() * (bead.from - start.position);
    const Vec3 after = end.rotation.conjugate() * (ends - end.position);
    return (after - before).norm() + bead.bend.norm();
  };
  const double far = std::max(way_of(from, last.from), way_of(to, last.to));
  const double size = (first.to - first.from).norm();
  if (contact::gap_at(with.shape, start, first, 0.5).distance > size + far) return;

  const auto place = [&](double share) {
    return share < 1 ? Capsule{from.at(share), to.at(share), first.radius} : last;
  };
  const auto frame = [&](double share) {
    if (!(share < 1)) return end;
    return with.path ? with.frame(step.time + share * step.h).pose() : start;
  };
  // A bit for each spot between the beads that is new and so near.
  const auto spots_within = [&](double share, double distance) {
    if (contact::least_gap(with.shape, frame(share), place(share)) >= distance) return 0u;
    const auto gaps = contact::all_gaps(with.shape, frame(share), place(share));
    unsigned spots = 0;
    for (const Spot spot : links_[link].spots) {
      const contact::SpotGap& near = gaps[static_cast<std::size_t>(spot)];
      if (!near.distinct || !(near.distance < distance) || is_known(link, index, spot)) continue;
      spots |= 1u << static_cast<unsigned>(spot);
    }
    return spots;
  };
  const auto note = [&](unsigned spots, double share, double when, bool passes) {
    const Pose there = frame(when);
    for (const Spot spot : links_[link].spots) {
      if (!(spots & (1u << static_cast<unsigned>(spot)))) continue;
      const Capsule own = place(when);
      const contact::SpotGap near = contact::gap_at(with.shape, there, own, spot);
      hits_.push_back({.share = share,
                       .link = link,
                       .obstacle = index,
                       .spot = spot,
                       .passes = passes,
                       .anchor = there.rotation.conjugate() * (own.at(near.along) - there.position),
                       .side = there.rotation.conjugate() * near.normal});
    }
  };
  const auto gap_at_share = [&](double share) {
    return contact::least_gap(with.shape, frame(share), place(share));
  };
  const double entered = -kEntered * step.touching;
  const auto enters = [&](double from_share, double at_start) {
    const double left = 1 - from_share;
    const Entry entry = find_entry(at_start, gap_at_share(1), left * far, [&](double share) {
      return gap_at_share(from_share + left * share);
    });
    if (entry.share > 1) return;
    const double when = from_share + left * entry.share;
    if (const unsigned spots = spots_within(when, 2 * kReached)) {
      note(spots, when, when, entry.passes);
    } else if (const unsigned inside = spots_within(1, entered)) {  // a bead comes first
      note(inside, 1, when, false);
    }
  };
  const double at_start = gap_at_share(0);
  if (at_start > kReached) {
    enters(0, at_start);
    return;
  }
  // Something of it touches already.
  if (const unsigned spots = spots_within(1, entered)) {
    const auto inside = [&](double share) { return (spots_within(share, 0) & spots) != 0; };
    const bool at_once = (spots_within(0, step.touching) & spots) != 0;
    const double share = at_once ? 0 : first_inside(0, 1, inside);
    note(spots, at_once ? 1 : share, share, false);
    return;
  }
  const bool touches = std::ranges::any_of(
      touches_, [&](const LinkTouch& at) { return at.link == link && at.obstacle == index; });
  if (touches) return;
  for (double leaves = kLeaves; leaves < 1; leaves *= 2) {  // a bead of it may leave, and return
    const double apart = gap_at_share(leaves);
    if (!(apart > kReached)) continue;
    enters(leaves, apart);
    return;
  }
}

}  // namespace taut::direct
